//! Connected components of pairs, found by a union-find structure over numbers.
//!
//! Each member points to another member of its component, or to itself; a member that points to itself represents the
//! component. Components are joined by the smallest members, so that the result does not depend on the order.

/// The member that represents the component of `member`; shortens the path there for the next time.
pub fn representative(parents: &mut [u32], mut member: u32) -> u32 {
    while parents[member as usize] != member {
        let above = parents[parents[member as usize] as usize];
        parents[member as usize] = above;
        member = above;
    }
    member
}

/// Joins the components of two members.
pub fn join(parents: &mut [u32], one: u32, other: u32) {
    let (one, other) = (representative(parents, one), representative(parents, other));
    parents[one.max(other) as usize] = one.min(other);
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_smallest_member_represents_whatever_the_order() {
        let pairs = [(5, 4), (1, 2), (4, 2), (0, 6)];
        let mut one: Vec<u32> = (0..7).collect();
        let mut other = one.clone();
        pairs.iter().for_each(|&(a, b)| join(&mut one, a, b));
        pairs.iter().rev().for_each(|&(a, b)| join(&mut other, b, a));
        for parents in [&mut one, &mut other] {
            let found: Vec<_> = (0..7).map(|member| representative(parents, member)).collect();
            assert_eq!(found, [0, 1, 1, 3, 1, 1, 0]);
        }
    }
}
