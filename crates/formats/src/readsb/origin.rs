//! How a position came about.

messages::codes! {
    /// Origin of a position in a receiver's list.
    pub enum Origin: u8, default Own {
        /// The aircraft states its own position (ADS-B).
        Own = 0, "own";
        /// A network of receivers has calculated the position from times of arrival.
        Multilateration = 1, "mlat";
        /// A ground station sends the position of an aircraft that radar sees (TIS-B).
        Traffic = 2, "tis-b";
        /// A ground station repeats the position that the aircraft states on another link (ADS-R).
        Repeated = 3, "ads-r";
        /// The aircraft states its position by contract, over satellites or HF (ADS-C).
        Contract = 4, "ads-c";
        /// Another feed, of unknown kind.
        Other = 5, "other";
    }
}

impl Origin {
    /// The origin by the type of a state, and by the lists of the fields that come from multilateration and from
    /// TIS-B. The lists are more precise: the type is the best one of all values.
    pub(super) fn of(kind: Option<&str>, multilaterated: &[String], traffic: &[String]) -> Self {
        let has_position = |fields: &[String]| fields.iter().any(|field| field == "lat");
        if has_position(multilaterated) {
            return Self::Multilateration;
        }
        if has_position(traffic) {
            return Self::Traffic;
        }
        match kind {
            None => Self::Own,
            Some("mlat") => Self::Multilateration,
            Some("adsc") => Self::Contract,
            Some(kind) if kind.starts_with("adsb_") => Self::Own,
            Some(kind) if kind.starts_with("tisb_") => Self::Traffic,
            Some(kind) if kind.starts_with("adsr_") => Self::Repeated,
            Some(_) => Self::Other,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_lists_of_fields_come_before_the_type() {
        let fields = |names: &[&str]| names.iter().map(|name| (*name).to_owned()).collect::<Vec<_>>();
        let (none, position) = (fields(&[]), fields(&["track", "lat", "lon"]));
        let track = fields(&["track"]);
        for (kind, multilaterated, traffic, origin) in [
            (None, &none, &none, Origin::Own),
            (Some("adsb_icao_nt"), &none, &none, Origin::Own),
            (Some("adsb_icao"), &position, &none, Origin::Multilateration),
            (Some("adsb_icao"), &track, &position, Origin::Traffic),
            (Some("mlat"), &none, &none, Origin::Multilateration),
            (Some("tisb_trackfile"), &none, &none, Origin::Traffic),
            (Some("adsr_other"), &none, &none, Origin::Repeated),
            (Some("adsc"), &none, &none, Origin::Contract),
            (Some("mode_s"), &none, &none, Origin::Other),
            (Some("unknown"), &none, &none, Origin::Other),
        ] {
            assert_eq!(Origin::of(kind, multilaterated, traffic), origin, "{kind:?}");
        }
    }
}
