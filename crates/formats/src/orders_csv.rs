//! Orders of operators as CSV rows: a row for each change of state.
//!
//! `time_s` is the time of the change and `ends_s` the expiry, both on the engine's clock. A parameter that an order
//! does not state is empty.

use messages::{NO_TRACK, OrderKind, OrderState, OrderStatus};

use crate::cells::{SensorId, Text, Time};
use crate::columns::columns;

columns! {
    OrderState: |row|
    "time_s" => Time(row.changed_ns),
    "order_id" => row.number,
    "state" => row.status().map(OrderStatus::word),
    "kind" => row.order.kind().map(OrderKind::word),
    "operator" => Text(row.order.operator()),
    "sensor_id" => SensorId::known(row.order.source),
    "other_sensor_id" => SensorId::known(row.order.other_source),
    "system_track_id" => unless(0, row.order.track),
    "other_track_id" => unless(NO_TRACK, row.order.other_track),
    "other_order_id" => unless(0, row.order.number),
    "value" => Some(row.order.value).filter(|value| !value.is_nan()),
    "name" => Text(row.order.name()),
    "ends_s" => (row.order.ends_ns != i64::MAX).then_some(Time(row.order.ends_ns)),
    "text" => Text(row.text()),
}

/// Returns the number, unless it is the number for none.
fn unless(none: u32, number: u32) -> Option<u32> {
    (number != none).then_some(number)
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
