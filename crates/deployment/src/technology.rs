//! Technologies of observation, as CAT062 distinguishes them.

settings::words! {
    /// Technology by which a source observes.
    pub enum Technology {
        /// Primary radar.
        Primary = "primary",
        /// Secondary radar without Mode S.
        Secondary = "secondary",
        /// Mode S radar.
        ModeS = "mode-s",
        /// ADS-B by 1090 MHz extended squitter.
        AdsB = "ads-b",
        /// Multilateration.
        Multilateration = "multilateration",
        /// Something else, or several of these in one.
        Other = "other",
        /// AIS of ships, which CAT062 counts among the others.
        Ais = "ais",
    }
}
