//! Replies of transponders that a radar receives with its plots.
//!
//! Each look receives the address with the callsign, and the code, independently with their probabilities. A received
//! address or code is garbled with a small probability: then any other value is reported, as after an overlap with
//! another reply. Plots of unresolved targets and false plots have no reply.

use messages::Identity;
use rand::RngExt as _;

use crate::look::LookParameters;
use crate::random::{Purpose, stream};
use crate::schedule::Slot;
use crate::sensor_settings::ReplySettings;
use crate::target::TargetState;

/// Bits of an address and of a code.
const ADDRESS_BITS: u32 = 24;
const CODE_BITS: u32 = 12;

impl ReplySettings {
    pub(crate) fn are_received(&self) -> bool {
        self.address_probability > 0.0 || self.code_probability > 0.0
    }
}

impl LookParameters {
    /// The reply of a target in a look.
    pub(crate) fn reply(&self, slot: &Slot, state: &TargetState) -> Identity {
        let replies = &self.settings.replies;
        let mut identity = Identity::default();
        if !replies.are_received() {
            return identity;
        }
        let mut random = stream(self.seed, Purpose::Reply, self.source, state.id.into(), slot.number);
        let mut received = |probability: f64, value: u32, bits: u32| {
            let [is_received, is_garbled] =
                [probability, replies.garbled_probability].map(|probability| random.random_bool(probability));
            let garbled = random.random_range(0..1u32 << bits);
            is_received.then_some(if is_garbled { garbled } else { value })
        };
        let code = u32::from(state.mode_3a.unwrap_or_default());
        let address = received(replies.address_probability, state.address, ADDRESS_BITS);
        let code = received(replies.code_probability, code, CODE_BITS);
        if let Some(address) = address {
            identity = identity.with_address(address).with_callsign(state.callsign);
        }
        if let (Some(code), Some(_)) = (code, state.mode_3a) {
            identity = identity.with_mode_3a(code as u16);
        }
        identity
    }
}
