//! Address and call sign of a fused track: I062/380, and I062/245 on request.

use asterix::categories::CAT062;
use asterix::field::{Elements, Field, elements, field, item, subitem};
use asterix::{Frn, RecordWriter};
use messages::Identity;

use super::items;

const AIRCRAFT: Frn = item(CAT062, "380");
const ADR: usize = subitem(CAT062, "380", "ADR");
const ADDRESS: Field = field(CAT062, &["380", "ADR"]);
const ID: usize = subitem(CAT062, "380", "ID");
const CALL_SIGN: Field = field(CAT062, &["380", "ID"]);
/// The call sign in the item of editions before 1.16.
const OLD_CALL_SIGN: Elements<2> = elements(CAT062, "245", ["STI", "CHR"]);
/// STI: the target itself sent the call sign.
const DOWNLINKED: i64 = 0;

/// Writes I062/245 if wanted, and I062/380.
pub(super) fn write(identity: &Identity, is_old_item_wanted: bool, record: &mut RecordWriter) {
    let call_sign = items::call_sign(identity);
    if let Some(call_sign) = call_sign.filter(|_| is_old_item_wanted) {
        record.write(&OLD_CALL_SIGN, [DOWNLINKED, call_sign]);
    }
    if let Some(address) = items::address(identity) {
        record.subitem(AIRCRAFT, ADR).put(ADDRESS, address);
    }
    if let Some(call_sign) = call_sign {
        record.subitem(AIRCRAFT, ID).put(CALL_SIGN, call_sign);
    }
}
