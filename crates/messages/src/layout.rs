//! Layouts of samples: a single declaration per sample, from which all descriptions of the bytes are derived.
//!
//! `sample!` writes the `#[repr(C)]` struct as given and, beside it, a table of fields and offsets. [`c_header`]
//! and [`python_module`] print those tables for the other languages. Two processes agree on a layout exactly if both
//! have the same [`Layout::fingerprint`], a hash of names, types, offsets and sizes. A comparison of type names and
//! sizes alone would miss two swapped `f64`. Each type has its own fingerprint, so a new or changed type does not
//! separate readers and publishers of other types.

use std::fmt::Write as _;

use crate::Constant;

/// Field of a sample.
#[derive(Clone, Copy, Debug)]
pub struct SampleField {
    /// Name, the same in every language.
    pub name: &'static str,
    /// Rust type as written in the declaration: a number type, another sample, or `[T; N]` of those.
    pub kind: &'static str,
    /// Offset in bytes from the start of the sample.
    pub offset: usize,
    /// Size in bytes.
    pub size: usize,
    /// Unit and meaning: the first line of the field's documentation.
    pub doc: &'static str,
}

/// Layout of a sample.
#[derive(Clone, Copy, Debug)]
pub struct Layout {
    /// Type name, shared by every language.
    pub name: &'static str,
    /// Size in bytes, with padding.
    pub size: usize,
    /// Alignment in bytes.
    pub align: usize,
    /// Fields in memory order; together they cover every byte (padding is a field too).
    pub fields: &'static [SampleField],
}

/// Type declared as a sample.
pub trait Sample: Copy {
    /// Memory map of the type.
    const LAYOUT: Layout;
    /// Fingerprint in the header of a slice of such samples.
    const SCHEMA: u64 = Self::LAYOUT.fingerprint();

    /// Returns the bytes of `samples` in memory order.
    fn octets(samples: &[Self]) -> &[u8];

    /// Returns the sample with these bytes; `None` if the number of bytes differs from the sample's size.
    fn of_octets(octets: &[u8]) -> Option<Self>;
}

/// Declares a shared-memory sample: a `#[repr(C)]` struct with asserted size, zero-copy marker, [`Layout`], and
/// default. A field without an explicit default is zero, which means "unknown" unless the field defines another
/// meaning.
macro_rules! sample {
    (@default) => { Default::default() };
    (@default $default:expr) => { $default };
    (
        $(#[doc = $doc:literal])*
        $name:ident, size $size:literal {
            $( $(#[doc = $fdoc:literal])+ $field:ident : $kind:ty $(= $default:expr)?, )*
        }
    ) => {
        $(#[doc = $doc])*
        #[derive(Clone, Copy, Debug, PartialEq)]
        #[repr(C)]
        pub struct $name {
            $( $(#[doc = $fdoc])+ pub $field: $kind, )*
        }

        impl Default for $name {
            fn default() -> Self {
                Self {
                    $( $field: $crate::layout::sample!(@default $($default)?), )*
                }
            }
        }

        // SAFETY: `#[repr(C)]`, `Copy`, and all fields are themselves fit for shared memory (checked in the
        // constant below), so any process may read its bytes at any mapped address.
        unsafe impl iceoryx2_bb_elementary_traits::zero_copy_send::ZeroCopySend for $name {
            unsafe fn type_name() -> &'static str {
                stringify!($name)
            }
        }

        impl $crate::layout::Sample for $name {
            const LAYOUT: $crate::layout::Layout = $crate::layout::Layout {
                name: stringify!($name),
                size: size_of::<$name>(),
                align: align_of::<$name>(),
                fields: &[ $( $crate::layout::SampleField {
                    name: stringify!($field),
                    kind: stringify!($kind),
                    offset: std::mem::offset_of!($name, $field),
                    size: {
                        const fn size<T>(_: fn(&$name) -> &T) -> usize { size_of::<T>() }
                        size(|sample| &sample.$field)
                    },
                    doc: [$($fdoc),+][0],
                }, )* ],
            };

            fn octets(samples: &[Self]) -> &[u8] {
                // SAFETY: every byte belongs to a field (checked in the constant below), so all are written.
                unsafe { std::slice::from_raw_parts(samples.as_ptr().cast(), size_of_val(samples)) }
            }

            fn of_octets(octets: &[u8]) -> Option<Self> {
                // SAFETY: the number of bytes is checked, and any bit pattern is a sample, because all fields are
                // numbers.
                (octets.len() == $size).then(|| unsafe { octets.as_ptr().cast::<Self>().read_unaligned() })
            }
        }

        #[cfg(feature = "serde")]
        impl serde::Serialize for $name {
            fn serialize<S: serde::Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
                serializer.serialize_bytes($crate::layout::Sample::octets(std::slice::from_ref(self)))
            }
        }

        #[cfg(feature = "serde")]
        impl<'de> serde::Deserialize<'de> for $name {
            fn deserialize<D: serde::Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
                let octets = <&[u8] as serde::Deserialize>::deserialize(deserializer)?;
                let sample = $crate::layout::Sample::of_octets(octets);
                sample.ok_or_else(|| serde::de::Error::invalid_length(octets.len(), &stringify!($name)))
            }
        }

        const _: () = {
            const fn fit_for_shared_memory<T: iceoryx2_bb_elementary_traits::zero_copy_send::ZeroCopySend>() {}
            $( fit_for_shared_memory::<$kind>(); )*
            assert!(size_of::<$name>() == $size, "the sample's size is part of the contract");
            let fields = <$name as $crate::layout::Sample>::LAYOUT.fields;
            let mut end = 0;
            let mut index = 0;
            while index < fields.len() {
                assert!(fields[index].offset == end, "padding must be a named field");
                end += fields[index].size;
                index += 1;
            }
            assert!(end == $size, "trailing padding must be a named field");
        };
    };
}
pub(crate) use sample;

/// All samples, in the order of containment: contained samples first.
pub const ALL: &[Layout] = &[
    crate::StageTimes::LAYOUT,
    crate::Identity::LAYOUT,
    crate::IdentityAges::LAYOUT,
    crate::Extent::LAYOUT,
    crate::Movement::LAYOUT,
    crate::TargetType::LAYOUT,
    crate::Covariance::LAYOUT,
    crate::BatchHeader::LAYOUT,
    crate::SensorTrack::LAYOUT,
    crate::SensorDetection::LAYOUT,
    crate::SensorBearing::LAYOUT,
    crate::SensorArrival::LAYOUT,
    crate::SensorFix::LAYOUT,
    crate::TargetStatement::LAYOUT,
    crate::SensorSpectrum::LAYOUT,
    crate::PlatformState::LAYOUT,
    crate::WideArea::LAYOUT,
    crate::Cue::LAYOUT,
    crate::Contribution::LAYOUT,
    crate::SystemTrack::LAYOUT,
    crate::Alarm::LAYOUT,
    crate::Alert::LAYOUT,
    crate::Decision::LAYOUT,
    crate::Registration::LAYOUT,
    crate::Counters::LAYOUT,
    crate::Health::LAYOUT,
    crate::Progress::LAYOUT,
    crate::Order::LAYOUT,
    crate::OrderState::LAYOUT,
    crate::FrameOrigin::LAYOUT,
    crate::WorkStep::LAYOUT,
    crate::Restored::LAYOUT,
];

impl Layout {
    /// Returns the hash of this layout, of the contained layouts, and of the header before every slice. A slice
    /// carries it, so that a subscriber built with another layout rejects the slice.
    pub const fn fingerprint(&self) -> u64 {
        let hash = Fnv(0xcbf2_9ce4_8422_2325).number(crate::SCHEMA_VERSION as usize);
        hash.layout(&crate::BatchHeader::LAYOUT).layout(self).0
    }

    /// Returns the schema of this sample for ROS 2 (`ros2msg`): the fields, then the fields of each contained
    /// sample.
    ///
    /// CDR, the encoding of ROS 2, places numbers in succession, each at a multiple of the number's size. Samples
    /// have the same layout in memory, since all padding consists of fields. Four bytes that state "little-endian",
    /// followed by the sample's bytes, are therefore a ROS 2 message.
    pub fn ros2_schema(&self) -> String {
        let mut out = String::new();
        self.ros2_fields(&mut out);
        let mut contained: Vec<&Self> = self.contained().collect();
        let mut next = 0;
        while let Some(layout) = contained.get(next).copied() {
            contained.extend(layout.contained());
            next += 1;
        }
        for (place, layout) in contained.iter().enumerate() {
            if !contained[..place].iter().any(|earlier| earlier.name == layout.name) {
                let _ = writeln!(out, "{}\nMSG: koseki/{}", "=".repeat(80), layout.name);
                layout.ros2_fields(&mut out);
            }
        }
        out
    }

    /// Returns the name of the field at this offset, as in `contributions[2].weight`.
    pub fn name_at(&self, offset: usize) -> String {
        let holds = |field: &&SampleField| (field.offset..field.offset + field.size).contains(&offset);
        let Some(field) = self.fields.iter().find(holds) else {
            return String::new();
        };
        let (element, count) = field.element();
        let size = field.size / count.unwrap_or(1).max(1);
        let within = offset - field.offset;
        let place = count.map(|_| format!("[{}]", within / size)).unwrap_or_default();
        let part = ALL.iter().find(|layout| layout.name == element);
        let part = part.map(|layout| format!(".{}", layout.name_at(within % size)));
        format!("{}{place}{}", field.name, part.unwrap_or_default())
    }

    fn ros2_fields(&self, out: &mut String) {
        for field in self.fields {
            let (element, count) = field.element();
            let count = count.map(|count| format!("[{count}]")).unwrap_or_default();
            let _ = writeln!(out, "{}{count} {} #{}", ros2_type(element), field.name, field.doc);
        }
    }

    /// Returns the sample types contained in this sample's fields, directly or as arrays.
    pub fn contained(&self) -> impl Iterator<Item = &'static Self> {
        let of = |field: &SampleField| ALL.iter().find(|layout| names(field.kind, layout.name));
        self.fields.iter().filter_map(of)
    }
}

/// FNV-1a, a simple hash suitable for compile-time evaluation.
struct Fnv(u64);

impl Fnv {
    const fn byte(self, byte: u8) -> Self {
        Self((self.0 ^ byte as u64).wrapping_mul(0x0100_0000_01b3))
    }

    const fn text(mut self, text: &str) -> Self {
        let bytes = text.as_bytes();
        let mut index = 0;
        while index < bytes.len() {
            // `stringify!` may or may not put blanks into `[f64; 3]`; blanks have no meaning.
            if bytes[index] != b' ' {
                self = self.byte(bytes[index]);
            }
            index += 1;
        }
        self.byte(0)
    }

    const fn layout(mut self, layout: &Layout) -> Self {
        self = self.text(layout.name).number(layout.size);
        let mut index = 0;
        while index < layout.fields.len() {
            let field = &layout.fields[index];
            self = self
                .text(field.name)
                .text(field.kind)
                .number(field.offset)
                .number(field.size);
            let mut contained = 0;
            while contained < ALL.len() {
                if names(field.kind, ALL[contained].name) {
                    self = self.layout(&ALL[contained]);
                }
                contained += 1;
            }
            index += 1;
        }
        self
    }

    const fn number(mut self, number: usize) -> Self {
        let mut index = 0;
        while index < 8 {
            self = self.byte((number >> (8 * index)) as u8);
            index += 1;
        }
        self
    }
}

/// Whether `kind`, a field's type, is `name` or an array of `name`.
const fn names(kind: &str, name: &str) -> bool {
    let (kind, name) = (kind.as_bytes(), name.as_bytes());
    let start = if kind[0] == b'[' { 1 } else { 0 };
    if kind.len() < start + name.len() {
        return false;
    }
    let mut index = 0;
    while index < name.len() {
        if kind[start + index] != name[index] {
            return false;
        }
        index += 1;
    }
    let end = start + name.len();
    end == kind.len() || kind[end] == b';'
}

impl SampleField {
    /// Returns the type of the field, split into element and count: `[f64; 3]` is (`f64`, 3).
    pub fn element(&self) -> (&'static str, Option<usize>) {
        let Some(inner) = self.kind.strip_prefix('[').and_then(|rest| rest.strip_suffix(']')) else {
            return (self.kind, None);
        };
        let name = inner.split(';').next().unwrap_or_default().trim();
        let size = size_of_name(name).unwrap_or_else(|| panic!("{}: unknown type {name}", self.name));
        (name, Some(self.size / size))
    }
}

fn size_of_name(name: &str) -> Option<usize> {
    match name {
        "u8" | "i8" => Some(1),
        "u16" | "i16" => Some(2),
        "u32" | "i32" | "f32" => Some(4),
        "u64" | "i64" | "f64" => Some(8),
        _ => ALL.iter().find(|layout| layout.name == name).map(|layout| layout.size),
    }
}

/// Codes or bits that belong together, for other languages.
#[derive(Clone, Debug)]
pub struct CodeGroup {
    /// Name as a type, such as `TrackState` or `ContributionBits`.
    pub name: &'static str,
    /// First part of the names of its constants in C.
    pub prefix: &'static str,
    /// Whether the values are bits that can be combined.
    pub is_flags: bool,
    /// The values.
    pub constants: Vec<Constant>,
}

impl SampleField {
    /// Returns the codes or bits that the field holds, as its documentation states them: "a `TrackState` code", "see
    /// `alert_bits`".
    pub fn codes(&self, groups: &[CodeGroup]) -> Option<CodeGroup> {
        let mut quoted = self.doc.split('`').skip(1).step_by(2);
        let is_meant = |group: &&CodeGroup, word: &str| match group.is_flags {
            true => snake_case(group.name) == word,
            false => group.name == word && self.doc.contains(&format!("`{word}` code")),
        };
        quoted.find_map(|word| groups.iter().find(|group| is_meant(group, word)).cloned())
    }
}

/// Returns `track_state` for `TrackState`.
fn snake_case(type_name: &str) -> String {
    constant_name(type_name).to_lowercase()
}

/// Returns all codes and bits of the samples.
pub fn code_groups() -> Vec<CodeGroup> {
    let bits = |name, prefix, constants: &[Constant]| CodeGroup {
        name,
        prefix,
        is_flags: true,
        constants: constants.to_vec(),
    };
    let codes = |name, prefix, constants| CodeGroup {
        name,
        prefix,
        is_flags: false,
        constants,
    };
    vec![
        bits("IdentityBits", "IDENTITY", crate::identity_bits::CONSTANTS),
        bits("MovementBits", "MOVEMENT", crate::movement_bits::CONSTANTS),
        bits("SensorTrackBits", "SENSOR_TRACK", crate::sensor_track_bits::CONSTANTS),
        bits(
            "SensorDetectionBits",
            "SENSOR_DETECTION",
            crate::sensor_detection_bits::CONSTANTS,
        ),
        bits(
            "SensorBearingBits",
            "SENSOR_BEARING",
            crate::sensor_bearing_bits::CONSTANTS,
        ),
        bits(
            "SensorArrivalBits",
            "SENSOR_ARRIVAL",
            crate::sensor_arrival_bits::CONSTANTS,
        ),
        bits(
            "PlatformStateBits",
            "PLATFORM_STATE",
            crate::platform_state_bits::CONSTANTS,
        ),
        bits("WideAreaBits", "WIDE_AREA", crate::wide_area_bits::CONSTANTS),
        bits("ContributionBits", "CONTRIBUTION", crate::contribution_bits::CONSTANTS),
        bits("AlertBits", "ALERT", crate::alert_bits::CONSTANTS),
        bits("AlertValueBits", "ALERT_VALUE", crate::alert_value_bits::CONSTANTS),
        bits("RegistrationBits", "REGISTRATION", crate::registration_bits::CONSTANTS),
        bits("WorkStepBits", "WORK_STEP", crate::work_step_bits::CONSTANTS),
        bits(
            "TargetStatementBits",
            "TARGET_STATEMENT",
            crate::target_statement_bits::CONSTANTS,
        ),
        codes("TrackState", "STATE", crate::TrackState::constants()),
        codes("TrackKind", "KIND", crate::TrackKind::constants()),
        codes("MotionMode", "MODE", crate::MotionMode::constants()),
        codes("ErrorModel", "ERROR_MODEL", crate::ErrorModel::constants()),
        codes("FusionRule", "RULE", crate::FusionRule::constants()),
        codes("IdentityKind", "IDENTITY_KIND", crate::IdentityKind::constants()),
        codes(
            "HorizontalMovement",
            "HORIZONTAL",
            crate::HorizontalMovement::constants(),
        ),
        codes("VerticalMovement", "VERTICAL", crate::VerticalMovement::constants()),
        codes(
            "LongitudinalMovement",
            "LONGITUDINAL",
            crate::LongitudinalMovement::constants(),
        ),
        codes("DetectionKind", "DETECTION_KIND", crate::DetectionKind::constants()),
        codes("DetectionMark", "DETECTION_MARK", crate::DetectionMark::constants()),
        codes("Stream", "STREAM", crate::Stream::constants()),
        codes("StepKind", "STEP", crate::StepKind::constants()),
        codes("ProcessKind", "PROCESS", crate::ProcessKind::constants()),
        codes("LifeState", "LIFE", crate::LifeState::constants()),
        codes("AlarmSeverity", "ALARM_SEVERITY", crate::AlarmSeverity::constants()),
        codes("AlarmEvent", "ALARM_EVENT", crate::AlarmEvent::constants()),
        codes("AlertKind", "ALERT_KIND", crate::AlertKind::constants()),
        codes("DecisionKind", "DECISION_KIND", crate::DecisionKind::constants()),
        codes("OrderKind", "ORDER", crate::OrderKind::constants()),
        codes("OrderStatus", "ORDER_STATUS", crate::OrderStatus::constants()),
        codes("Refusal", "REFUSAL", crate::Refusal::constants()),
        codes("TargetCategory", "CATEGORY", crate::TargetCategory::constants()),
        codes("AidKind", "AID", crate::AidKind::constants()),
        codes("NavigationStatus", "NAVIGATION", crate::NavigationStatus::constants()),
        codes("Emergency", "EMERGENCY", crate::Emergency::constants()),
    ]
}

/// Returns the constants for a reader in another language, by name.
fn constants() -> Vec<(String, u64, &'static str)> {
    let lengths = [
        (
            "CONTRIBUTIONS_MAX",
            crate::CONTRIBUTIONS_MAX,
            "Length of SystemTrack.contributions.",
        ),
        ("COUNTERS_MAX", crate::COUNTERS_MAX, "Length of Counters.values."),
    ];
    let schema = |layout: &Layout| {
        (
            format!("{}_SCHEMA", constant_name(layout.name)),
            layout.fingerprint(),
            "BatchHeader.schema of its slices.",
        )
    };
    // Only samples that are not part of other samples travel in slices.
    let travels = |layout: &&Layout| {
        let part = |whole: &Layout| whole.contained().any(|part| part.name == layout.name);
        layout.name != crate::BatchHeader::LAYOUT.name && !ALL.iter().any(part)
    };
    let mut list: Vec<_> = ALL.iter().filter(travels).map(schema).collect();
    list.extend(lengths.map(|(name, length, doc)| (name.to_owned(), length as u64, doc)));
    for group in code_groups() {
        for constant in group.constants {
            let word = constant.word.replace('-', "_").to_uppercase();
            list.push((format!("{}_{word}", group.prefix), constant.value, constant.doc));
        }
    }
    list
}

/// Returns `SYSTEM_TRACK` for `SystemTrack`.
fn constant_name(type_name: &str) -> String {
    let mut name = String::new();
    for (index, letter) in type_name.char_indices() {
        if index > 0 && letter.is_uppercase() {
            name.push('_');
        }
        name.push(letter.to_ascii_uppercase());
    }
    name
}

/// Returns the layouts as a C11 header, with static assertions.
pub fn c_header() -> String {
    let mut out = String::from(
        "/* Koseki's samples in shared memory. Written by `cargo run -p koseki-messages --example layouts`; a test keeps it true. */\n\
         #ifndef KOSEKI_MESSAGES_H\n#define KOSEKI_MESSAGES_H\n\n#include <assert.h>\n#include <stddef.h>\n#include <stdint.h>\n\n",
    );
    for (name, value, doc) in constants() {
        let _ = writeln!(out, "#define KOSEKI_{name} UINT64_C({value:#x}) /* {doc} */");
    }
    for layout in ALL {
        let _ = writeln!(out, "\ntypedef struct Koseki{} {{", layout.name);
        for field in layout.fields {
            let (element, count) = field.element();
            let count = count.map(|count| format!("[{count}]")).unwrap_or_default();
            let _ = writeln!(out, "    {} {}{count}; /*{} */", c_type(element), field.name, field.doc);
        }
        let _ = writeln!(
            out,
            "}} Koseki{0};\nstatic_assert(sizeof(Koseki{0}) == {1}, \"size\");",
            layout.name, layout.size
        );
        for field in layout.fields {
            let _ = writeln!(
                out,
                "static_assert(offsetof(Koseki{}, {}) == {}, \"offset\");",
                layout.name, field.name, field.offset
            );
        }
    }
    out.push_str("\n#endif\n");
    out
}

fn c_type(element: &str) -> String {
    match element {
        "f64" => "double".to_owned(),
        "f32" => "float".to_owned(),
        "u8" | "u16" | "u32" | "u64" => format!("uint{}_t", &element[1..]),
        "i8" | "i16" | "i32" | "i64" => format!("int{}_t", &element[1..]),
        sample => format!("Koseki{sample}"),
    }
}

/// Returns the layouts as a Python module of `ctypes` structures, compatible with iceoryx2's Python package.
pub fn python_module() -> String {
    let mut out = String::from(
        "\"\"\"Koseki's samples in shared memory, for ctypes and the iceoryx2 Python package.\n\n\
         To join an instance, set iceoryx2's root-path to the folder that `koseki status` names, and its prefix to the \
         line in\nthe file koseki-instance there, which is another one at each start.\n\n\
         Written by `cargo run -p koseki-messages --example layouts`; a test keeps it true.\n\"\"\"\n\nimport ctypes\n\n",
    );
    for (name, value, doc) in constants() {
        let _ = writeln!(out, "{name} = {value:#x}  # {doc}");
    }
    for layout in ALL {
        let _ = writeln!(out, "\n\nclass {}(ctypes.Structure):\n    _fields_ = [", layout.name);
        for field in layout.fields {
            let (element, count) = field.element();
            let count = count.map(|count| format!(" * {count}")).unwrap_or_default();
            let _ = writeln!(
                out,
                "        (\"{}\", {}{count}),  #{}",
                field.name,
                python_type(element),
                field.doc
            );
        }
        let _ = writeln!(
            out,
            "    ]\n\n    @staticmethod\n    def type_name() -> str:\n        return \"{0}\"\n\n\nassert ctypes.sizeof({0}) == {1}",
            layout.name, layout.size
        );
        for field in layout.fields {
            let _ = writeln!(out, "assert {}.{}.offset == {}", layout.name, field.name, field.offset);
        }
    }
    out
}

/// Returns the module of the Python package with the codes and bits of the samples: each group is an enumeration, as a
/// type checker can read it.
pub fn python_codes() -> String {
    let mut out = String::from(
        "\"\"\"Codes and bits of the samples, as enumerations.\n\n\
         Written by `cargo run -p koseki-messages --example layouts`; a test keeps the file true.\n\"\"\"\n\n\
         from __future__ import annotations\n\nimport enum\n",
    );
    let groups = code_groups();
    for group in &groups {
        let base = if group.is_flags { "IntFlag" } else { "IntEnum" };
        let word = |constant: &Constant| constant.word.replace('-', "_").to_uppercase();
        let docs = group
            .constants
            .iter()
            .map(|each| format!("{}: {}", word(each), each.doc));
        let docs: Vec<String> = docs.collect();
        let _ = writeln!(
            out,
            "\n\nclass {}(enum.{base}):\n    \"\"\"{}\"\"\"\n",
            group.name,
            docs.join("\n    ")
        );
        for constant in &group.constants {
            let _ = writeln!(out, "    {} = {}", word(constant), constant.value);
        }
    }
    let names = |form: &dyn Fn(&str) -> String| -> String {
        let lines = groups.iter().map(|group| format!("    {},\n", form(group.name)));
        lines.collect()
    };
    let _ = write!(
        out,
        "\n\n__all__ = [\n{}]\n\n\
         #: Codes and bits by name, such as `CODES[\"TrackState\"]`.\n\
         CODES: dict[str, type[enum.IntEnum] | type[enum.IntFlag]] = {{\n{}}}\n\n\
         for _group in CODES.values():\n    _group.__module__ = \"koseki\"\n",
        names(&|name| format!("\"{name}\"")),
        names(&|name| format!("\"{name}\": {name}"))
    );
    out
}

fn python_type(element: &str) -> String {
    match element {
        "f64" => "ctypes.c_double".to_owned(),
        "f32" => "ctypes.c_float".to_owned(),
        "u8" | "u16" | "u32" | "u64" => format!("ctypes.c_uint{}", &element[1..]),
        "i8" | "i16" | "i32" | "i64" => format!("ctypes.c_int{}", &element[1..]),
        sample => sample.to_owned(),
    }
}

fn ros2_type(element: &str) -> String {
    match element {
        "f64" | "f32" => format!("float{}", &element[1..]),
        "u8" | "u16" | "u32" | "u64" => format!("uint{}", &element[1..]),
        "i8" | "i16" | "i32" | "i64" => format!("int{}", &element[1..]),
        sample => format!("koseki/{sample}"),
    }
}
