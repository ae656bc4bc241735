//! Numbers out of bits and bytes. Most significant first throughout, as everything in ASTERIX.

/// `width` bits (at most 64) from bit `at` on, counted from the most significant bit of the first byte.
pub(super) fn bits(bytes: &[u8], at: usize, width: usize) -> u64 {
    debug_assert!(width <= 64);
    let end = at + width;
    let octets = &bytes[at / 8..end.div_ceil(8)];
    let number = octets
        .iter()
        .fold(0u128, |number, &octet| number << 8 | u128::from(octet));
    let behind = octets.len() * 8 - at % 8 - width;
    (number >> behind) as u64 & (u64::MAX >> (64 - width))
}

/// Writes the low `width` bits of `number` from bit `at` on, where there are zeros and `number` has no more bits.
pub(super) fn put(bytes: &mut [u8], at: usize, width: usize, number: u64) {
    debug_assert!(width <= 64 && number <= u64::MAX >> (64 - width));
    let end = at + width;
    let octets = &mut bytes[at / 8..end.div_ceil(8)];
    let behind = octets.len() * 8 - at % 8 - width;
    if let [octet] = octets {
        *octet |= (number as u8) << behind; // flags and short codes: most elements
        return;
    }
    let mut rest = u128::from(number) << behind;
    for octet in octets.iter_mut().rev() {
        *octet |= rest as u8;
        rest >>= 8;
    }
}

/// The two's complement number in the low `width` bits.
pub(super) fn sign_extend(number: u64, width: usize) -> i64 {
    let unused = 64 - width;
    ((number << unused) as i64) >> unused
}

/// The FSPEC bits of one byte, the first item in bit 0, without the FX bit.
pub(super) fn fspec_bits(octet: u8) -> u8 {
    (octet & 0xFE).reverse_bits()
}

/// The inverse of [`fspec_bits`], with the FX bit.
pub(super) fn fspec_octet(bits: u8, goes_on: bool) -> u8 {
    (bits & 0x7F).reverse_bits() | u8::from(goes_on)
}

/// True if a byte's FX bit announces another byte.
pub(super) fn goes_on(octet: u8) -> bool {
    octet & 1 == 1
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn bits_count_from_the_most_significant_and_cross_octets() {
        let bytes = [0b1010_0000, 0b0000_0001, 0xFF];
        assert_eq!(bits(&bytes, 0, 3), 0b101);
        assert_eq!(bits(&bytes, 7, 10), 0b11);
        assert_eq!(bits(&bytes, 15, 9), 0b1_1111_1111);
        assert_eq!(bits(&[0xFF; 9], 4, 64), u64::MAX);
    }

    #[test]
    fn bits_are_put_where_they_are_read() {
        for (at, width) in [(0, 1), (3, 5), (7, 10), (4, 64), (9, 24), (71, 1)] {
            let number = 0xA5C3_96F0_5A3C_690F >> (64 - width);
            let mut bytes = [0; 9];
            put(&mut bytes, at, width, number);
            assert_eq!(bits(&bytes, at, width), number);
            let set: u32 = bytes.iter().map(|octet| octet.count_ones()).sum();
            assert_eq!(set, number.count_ones(), "nothing beside them");
        }
    }

    #[test]
    fn signs_extend_from_the_width() {
        assert_eq!(sign_extend(0b0111, 4), 7);
        assert_eq!(sign_extend(0b1000, 4), -8);
        assert_eq!(sign_extend(u64::MAX, 64), -1);
    }

    #[test]
    fn fspec_bits_put_the_first_item_lowest() {
        assert_eq!(fspec_bits(0b1000_0000), 0b000_0001);
        assert_eq!(fspec_bits(0b0000_0011), 0b100_0000);
        assert!(goes_on(0b0000_0011));
        for octet in 0..=u8::MAX {
            assert_eq!(fspec_octet(fspec_bits(octet), goes_on(octet)), octet);
        }
    }
}
