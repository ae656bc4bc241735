//! Each error, with its whole message: what, where, found and expected.

use asterix::Mode::{Lenient, Strict};
use asterix::{Error, blocks};

use crate::sample::{PLOT_OR_TRACK, SAMPLE, block, error, item, read};

/// The error of the first block that is none.
fn framing(bytes: &[u8]) -> (Error, usize) {
    let mut good = 0;
    let mut all = blocks(bytes);
    let error = all.find_map(|block| block.map(|_| good += 1).err()).expect("an error");
    assert_eq!(all.next(), None, "nothing follows an impossible block");
    (error, good)
}

fn message(error: &Error, offset: usize, expected: &str) {
    assert_eq!(error.to_string(), expected);
    assert_eq!(error.offset(), offset);
}

#[test]
fn a_header_needs_three_octets() {
    let (error, good) = framing(&[&block(250, &[0x80, 0, 0])[..], &[250, 0]].concat());
    assert_eq!(good, 1);
    message(&error, 6, "byte 6: a block header takes 3 octets, 2 left");
}

#[test]
fn a_block_is_no_shorter_than_its_header() {
    let (error, _) = framing(&[48, 0, 2, 0, 0]);
    message(
        &error,
        0,
        "byte 0: block of category 048 gives its length as 2 octets, its header alone takes 3",
    );
    assert_eq!(blocks(&[48, 0, 3]).count(), 1, "an empty block is a block");
}

#[test]
fn a_block_is_no_longer_than_the_bytes() {
    let (error, _) = framing(&[48, 1, 0, 0xFF]);
    message(
        &error,
        0,
        "byte 0: block of category 048 gives its length as 256 octets, 4 left",
    );
}

#[test]
fn an_fspec_ends_within_its_block() {
    read(&SAMPLE, Lenient, &[0x81], |record| {
        message(
            &record.unwrap_err(),
            3,
            "byte 3: category 250: the FSPEC runs off the end of the block after 1 octets",
        );
    });
}

#[test]
fn an_fspec_has_at_most_eight_octets() {
    read(&SAMPLE, Lenient, &[0x01; 9], |record| {
        message(
            &record.unwrap_err(),
            3,
            "byte 3: category 250: the FSPEC goes on after 8 octets, the most there can be",
        );
    });
}

#[test]
fn a_record_has_an_item() {
    read(&SAMPLE, Lenient, &[0x00, 0x00], |record| {
        message(
            &record.unwrap_err(),
            3,
            "byte 3: category 250: the FSPEC announces no item",
        );
    });
}

#[test]
fn an_fspec_announces_only_what_the_edition_defines() {
    let expected = |frn: u8| {
        format!(
            "byte 3: category 250: the FSPEC announces an item at FRN {frn}, \
             where this edition defines none"
        )
    };
    read(&SAMPLE, Lenient, &[0x01, 0x04, 0], |record| {
        message(&record.unwrap_err(), 3, &expected(13));
    });
    read(&SAMPLE, Lenient, &[0x01, 0x01, 0x20, 0], |record| {
        message(&record.unwrap_err(), 3, &expected(17));
    });
}

#[test]
fn a_profile_is_decided_by_an_item_that_is_there() {
    read(&PLOT_OR_TRACK, Lenient, &[0b1010_0000, 1, 2, 0, 9], |record| {
        message(
            &record.unwrap_err(),
            3,
            "byte 3: category 251: I251/020 decides the profile, but is absent",
        );
    });
    read(&PLOT_OR_TRACK, Lenient, &[0b1110_0000, 1, 2, 0x80, 0, 9], |record| {
        message(
            &record.unwrap_err(),
            3,
            "byte 3: category 251: I251/020 decides the profile, its value 2 has none",
        );
    });
}

#[test]
fn an_item_ends_within_its_block() {
    let truncated = |name: &str, octets: &[u8], offset: usize, needed: usize| {
        let left = octets.len();
        message(
            &error(Lenient, name, octets),
            offset,
            &format!("byte {offset}: I250/{name} takes at least {needed} octets, {left} left"),
        );
    };
    truncated("020", &[1], 4, 2);
    truncated("060", &[], 4, 1);
    truncated("060", &[0x01, 0x00], 4, 3);
    truncated("070", &[], 4, 1);
    truncated("070", &[2, 0, 0, 0], 4, 5);
    truncated("080", &[0x03, 0x01], 5, 3);
    truncated("100", &[0x01], 5, 2);
    truncated("100", &[0xA0, 0x00], 5, 3);
    truncated("RE", &[5, 0], 5, 5);
    truncated("130", &[0x01], 6, 2);
    truncated("RFS", &[], 6, 1);
    truncated("RFS", &[1], 6, 2);
    truncated("RFS", &[2, 2, 0, 0, 6], 6, 6);
}

#[test]
fn an_explicit_item_holds_its_length_octet() {
    message(
        &error(Lenient, "RE", &[0, 0]),
        5,
        "byte 5: I250/RE gives its length as 0, the least is 1",
    );
}

#[test]
fn an_extended_item_goes_on_for_a_limited_length() {
    let defined = [0x0B, 0xFF, 0xFD, 0x03];
    message(
        &error(Strict, "060", &[&defined[..], &[0x00]].concat()),
        4,
        "byte 4: I250/060 goes on for more than 0 octets after its last defined part",
    );
    message(
        &error(Lenient, "060", &[&defined[..], &[0x01; 4], &[0x00]].concat()),
        4,
        "byte 4: I250/060 goes on for more than 4 octets after its last defined part",
    );
    item("060", &[&defined[..], &[0x01; 3], &[0x00]].concat()); // four are taken
}

#[test]
fn a_compound_item_announces_only_what_the_edition_defines() {
    let expected = |position: usize| {
        format!(
            "byte 5: I250/100 announces a subitem at position {position}, \
             where this edition defines none"
        )
    };
    message(&error(Lenient, "100", &[0x40, 0]), 5, &expected(2));
    message(&error(Lenient, "100", &[0x01, 0x40, 0]), 5, &expected(9));
    message(&error(Lenient, "100", &[0x01; 10]), 5, &expected(57));
}

#[test]
fn a_random_field_sequence_announces_only_what_the_edition_defines_and_no_sequence() {
    for frn in [0, 13, 16, 17, 57, 255] {
        message(
            &error(Lenient, "RFS", &[1, frn, 0, 0, 0]),
            6,
            &format!(
                "byte 6: I250/RFS announces an item at FRN {frn}, \
                 where this edition defines none that can be in a sequence"
            ),
        );
    }
}

#[test]
fn spare_bits_are_zero_in_strict_mode() {
    let set = |name: &str, octets: &[u8], offset: usize| {
        message(
            &error(Strict, name, octets),
            offset,
            &format!("byte {offset}: I250/{name} has a spare bit set, expected all zero"),
        );
    };
    set("010", &[0x40, 0], 4);
    set("060", &[0x01, 0, 0x01, 0x80], 4);
    set("120", &[0x02], 5);
    set("RFS", &[2, 2, 0, 0, 1, 0x40, 0], 6);
    set("RFS", &[2, 14, 3, 0xFF, 0xFF, 1, 0x40, 0], 6); // behind an explicit item
}
