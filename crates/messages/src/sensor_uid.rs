//! Identity of a sensor across deployments.

/// Returns the default identity of the sensor called `name`: FNV-1a over the bytes of the name, 32 bits, 1 instead
/// of 0. Two sensors with colliding names count as the same sensor. This makes fusion across deployments more
/// conservative, never less.
pub const fn sensor_uid(name: &str) -> u32 {
    let octets = name.as_bytes();
    let (mut hash, mut index) = (0x811c_9dc5_u32, 0);
    while index < octets.len() {
        hash = (hash ^ octets[index] as u32).wrapping_mul(0x0100_0193);
        index += 1;
    }
    if hash == 0 { 1 } else { hash }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_hash_is_the_one_that_is_documented() {
        // Published test values of FNV-1a.
        assert_eq!(
            (sensor_uid(""), sensor_uid("a"), sensor_uid("foobar")),
            (0x811c_9dc5, 0xe40c_292c, 0xbf9c_f968)
        );
    }
}
