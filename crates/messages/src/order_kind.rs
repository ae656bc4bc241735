//! Registry of orders: a line each.
//!
//! A code never changes and is never reused, because event logs and recordings identify kinds by code. The registry
//! states the parameters of each kind; [`check_order`](crate::check_order) and the command line read them from here.

/// Parameter of an order: a field of `Order`.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Parameter {
    /// Source concerned: `Order::source`.
    Source,
    /// Source from which a hand-over leads: `Order::other_source`.
    From,
    /// System track: `Order::track`.
    Track,
    /// Second system track: `Order::other_track`.
    With,
    /// Track number at the source: `Order::other_track`.
    SensorTrack,
    /// Number: `Order::value`.
    Value,
    /// Word: `Order::name`.
    Name,
    /// Number of another order: `Order::number`.
    Number,
    /// Source whose tracks a tracker makes: `Order::source`.
    Tracker,
    /// Place of a target, as `DesignatedPlace` reads it: `Order::name`.
    Place,
    /// Standard deviation of a place, metres: `Order::value`.
    Sigma,
}

impl Parameter {
    /// All parameters.
    pub const ALL: [Self; 11] = [
        Self::Source,
        Self::From,
        Self::Track,
        Self::With,
        Self::SensorTrack,
        Self::Value,
        Self::Name,
        Self::Number,
        Self::Tracker,
        Self::Place,
        Self::Sigma,
    ];

    /// Returns the word used on command lines and in JSON.
    pub const fn word(self) -> &'static str {
        match self {
            Self::Source => "source",
            Self::From => "from",
            Self::Track => "track",
            Self::With => "with",
            Self::SensorTrack => "sensor_track",
            Self::Value => "value",
            Self::Name => "name",
            Self::Number => "number",
            Self::Tracker => "tracker",
            Self::Place => "place",
            Self::Sigma => "sigma",
        }
    }

    /// Returns the parameter whose field this parameter shares.
    pub(crate) const fn field(self) -> Self {
        match self {
            Self::SensorTrack => Self::With,
            Self::Tracker => Self::Source,
            Self::Place => Self::Name,
            Self::Sigma => Self::Value,
            other => other,
        }
    }
}

macro_rules! orders {
    ($(
        $name:ident = $code:literal, $word:literal, $duration:ident,
            needs [$($needs:ident)*], may [$($may:ident)*], value in [$low:expr, $high:expr],
            $summary:literal;
    )*) => {
        /// Kind of an order.
        #[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
        #[repr(u16)]
        pub enum OrderKind {
            $( #[doc = $summary] $name = $code, )*
        }

        impl OrderKind {
            /// All kinds, in the order of the registry.
            pub const ALL: &'static [Self] = &[ $( Self::$name, )* ];

            /// Returns the word used on command lines, in JSON and in reports.
            pub const fn word(self) -> &'static str {
                match self { $( Self::$name => $word, )* }
            }

            /// Returns the effect, in one sentence.
            pub const fn summary(self) -> &'static str {
                match self { $( Self::$name => $summary, )* }
            }

            /// Returns the parameters that must be given.
            pub const fn needs(self) -> &'static [Parameter] {
                match self { $( Self::$name => &[ $( Parameter::$needs, )* ], )* }
            }

            /// Returns the parameters that may be given.
            pub const fn may(self) -> &'static [Parameter] {
                match self { $( Self::$name => &[ $( Parameter::$may, )* ], )* }
            }

            /// Returns the lowest and the highest value of [`Parameter::Value`].
            pub const fn range(self) -> (f64, f64) {
                match self { $( Self::$name => ($low, $high), )* }
            }

            /// Returns whether the effect lasts until the order is cancelled, replaced or expired.
            pub const fn lasts(self) -> bool {
                match self { $( Self::$name => Duration::$duration.lasts(), )* }
            }
        }
    };
}

/// Duration of an effect.
enum Duration {
    /// Until the order is cancelled, replaced or expired.
    Lasts,
    /// A moment.
    Once,
}

impl Duration {
    const fn lasts(self) -> bool {
        matches!(self, Self::Lasts)
    }
}

orders! {
    Condition = 1, "condition", Lasts, needs [Name], may [Source], value in [0.0, 0.0],
        "A weather condition holds for the accuracy of a source, or of all sources (TI-7).";
    Snapshot = 2, "snapshot", Once, needs [], may [], value in [0.0, 0.0],
        "Fusion publishes a snapshot of the engine, for a recorder.";
    Out = 3, "out", Lasts, needs [Source], may [], value in [0.0, 0.0],
        "The reports of a source are counted and not used.";
    In = 4, "in", Once, needs [Source], may [], value in [0.0, 0.0],
        "The reports of a source that is out are used again.";
    Eta = 5, "eta", Lasts, needs [Value], may [Source From], value in [0.0, 1.0],
        "First weight eta_0 of a hand-over to a source, from another source or from any (TI-13).";
    Adjustment = 6, "k", Lasts, needs [Source Value], may [], value in [1e-9, 1e9],
        "Adjustment coefficient k of a source: smaller values are preferred (TI-8).";
    Rule = 7, "rule", Lasts, needs [Name], may [], value in [0.0, 0.0],
        "A rule weighs the sources of all system tracks.";
    Drop = 8, "drop", Lasts, needs [Track], may [], value in [0.0, 0.0],
        "A system track ends, and its sensor tracks start no other.";
    Join = 9, "join", Lasts, needs [Track With], may [], value in [0.0, 0.0],
        "Two system tracks are one target: the older number remains.";
    Split = 10, "split", Lasts, needs [Track Source SensorTrack], may [], value in [0.0, 0.0],
        "A sensor track leaves its system track and gets a system track of its own.";
    Renumber = 11, "renumber", Once, needs [Track], may [], value in [0.0, 0.0],
        "A system track gets a new number, and the old number ends.";
    Reset = 12, "reset", Once, needs [Source], may [], value in [0.0, 0.0],
        "Everything learned of a source is forgotten: errors, accuracy, detection probability, dependence.";
    Cancel = 13, "cancel", Once, needs [Number], may [], value in [0.0, 0.0],
        "An order in force ends.";
    Qnh = 14, "qnh", Lasts, needs [Name Value], may [], value in [850.0, 1100.0],
        "The pressure at mean sea level in a region, hPa, by the name of its `[[qnh]]`.";
    Designate = 15, "designate", Once, needs [Tracker Place Sigma], may [], value in [0.1, 1e5],
        "A tracker follows the target at a place of this standard deviation, metres.";
}

impl OrderKind {
    /// Returns the code used in samples.
    pub const fn code(self) -> u16 {
        self as u16
    }

    /// Returns the kind of a sample's code; `None` for a code of a later version.
    pub fn from_code(code: u16) -> Option<Self> {
        Self::ALL.iter().copied().find(|kind| kind.code() == code)
    }

    /// Returns the kind named by a word; `None` for an unknown word.
    pub fn from_word(word: &str) -> Option<Self> {
        Self::ALL.iter().copied().find(|kind| kind.word() == word)
    }

    /// Returns the kinds for other languages.
    pub fn constants() -> Vec<crate::Constant> {
        let constant = |kind: &Self| crate::Constant {
            word: kind.word(),
            value: u64::from(kind.code()),
            doc: kind.summary(),
        };
        Self::ALL.iter().map(constant).collect()
    }
}
