//! Orders of operators as CSV rows: a row for each change of state.
//!
//! `time_s` is the time of the change and `ends_s` the expiry, both on the engine's clock. A parameter that an order
//! does not state is empty.

use std::io::{self, Write};

use messages::{NO_SOURCE, NO_TRACK, OrderKind, OrderState, OrderStatus};

use crate::rows::{Reference, Row};

impl Row for OrderState {
    fn columns() -> String {
        "time_s,order_id,state,kind,operator,sensor_id,other_sensor_id,system_track_id,other_track_id,other_order_id,\
         value,name,ends_s,text"
            .to_owned()
    }

    fn write(&self, out: &mut impl Write, reference: &Reference) -> io::Result<()> {
        let order = &self.order;
        reference.write_time(out, self.changed_ns)?;
        let state = self.status().map_or("", OrderStatus::word);
        let kind = order.kind().map_or("", OrderKind::word);
        write!(out, ",{},{state},{kind},{}", self.number, quoted(order.operator()))?;
        for source in [order.source, order.other_source] {
            match source {
                NO_SOURCE => write!(out, ",")?,
                source => write!(out, ",{}", reference.sensor_id(source))?,
            }
        }
        for (number, none) in [(order.track, 0), (order.other_track, NO_TRACK), (order.number, 0)] {
            match number == none {
                true => write!(out, ",")?,
                false => write!(out, ",{number}")?,
            }
        }
        match order.value.is_nan() {
            true => write!(out, ",")?,
            false => write!(out, ",{}", order.value)?,
        }
        write!(out, ",{},", quoted(order.name()))?;
        if order.ends_ns != i64::MAX {
            reference.write_time(out, order.ends_ns)?;
        }
        write!(out, ",{}", quoted(self.text()))
    }
}

/// Returns the text in quotation marks where a table needs them.
fn quoted(text: &str) -> String {
    match text.contains([',', '"']) {
        true => format!("\"{}\"", text.replace('"', "\"\"")),
        false => text.to_owned(),
    }
}

#[cfg(test)]
mod tests {
    use messages::{Order, Refusal};

    use super::*;
    use crate::rows::RowWriter;

    #[test]
    fn a_row_states_the_order_and_its_state() {
        let order = Order {
            token: 1,
            value: 0.25,
            source: 1,
            ends_ns: 90_500_000_000,
            ..Order::new(OrderKind::Eta).with_operator("anna, north")
        };
        let in_force = OrderState {
            order,
            changed_ns: 60_000_000_000,
            number: 3,
            status: OrderStatus::InForce.code(),
            ..OrderState::default()
        };
        let drop = Order {
            token: 2,
            track: 7,
            ..Order::new(OrderKind::Drop)
        };
        let mut writer = RowWriter::<OrderState, _>::begin(Vec::new(), 0).unwrap();
        writer.write(&in_force.with_sentence()).unwrap();
        let refused = OrderState::refused(&drop, Refusal::UnknownTrack, 61_000_000_000);
        writer.write(&refused.with_sentence()).unwrap();
        let text = String::from_utf8(writer.into_inner()).unwrap();
        let rows: Vec<&str> = text.lines().skip(1).collect();
        assert_eq!(
            rows,
            [
                "60,3,in-force,eta,\"anna, north\",2,,,,,0.25,,90.5,in force",
                "61,0,refused,drop,,,,7,,,,,,\"there is no such system track, or it has ended\""
            ]
        );
    }
}
