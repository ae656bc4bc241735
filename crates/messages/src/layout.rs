//! One declaration per sample, from which everything that must agree on its bytes is derived.
//!
//! `sample!` writes the `#[repr(C)]` struct as given and, beside it, a table of its fields with their offsets.
//! [`c_header`] and [`python_module`] print those tables for the other languages. Two processes agree on a layout
//! exactly if they agree on [`fingerprint`], which hashes names, types, offsets and sizes: that is stronger than
//! comparing type names and sizes, under which two swapped `f64` would pass unnoticed.

use std::fmt::Write as _;

/// One field of a sample.
#[derive(Clone, Copy, Debug)]
pub struct Field {
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

/// One sample's layout.
#[derive(Clone, Copy, Debug)]
pub struct Layout {
    /// Type name, shared by every language.
    pub name: &'static str,
    /// Size in bytes, with padding.
    pub size: usize,
    /// Alignment in bytes.
    pub align: usize,
    /// Fields in memory order; together they cover every byte (padding is a field too).
    pub fields: &'static [Field],
}

/// A type that was declared as a sample.
pub trait Sample: Copy {
    /// Its memory map.
    const LAYOUT: Layout;
}

/// Declares a shared-memory sample: a `#[repr(C)]` struct with its asserted size, its zero-copy marker and its
/// [`Layout`].
macro_rules! sample {
    (
        $(#[doc = $doc:literal])*
        $(#[derive($($extra:ident),*)])?
        $name:ident, size $size:literal {
            $( $(#[doc = $fdoc:literal])+ $field:ident : $kind:ty, )*
        }
    ) => {
        $(#[doc = $doc])*
        #[derive(Clone, Copy, Debug, PartialEq $($(, $extra)*)?)]
        #[repr(C)]
        pub struct $name {
            $( $(#[doc = $fdoc])+ pub $field: $kind, )*
        }

        // SAFETY: `#[repr(C)]`, `Copy`, and made only of fields that are themselves fit for shared memory (checked in
        // the constant below), so any process may read its bytes wherever they are mapped.
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
                fields: &[ $( $crate::layout::Field {
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

/// Every sample, those that others contain first.
pub const ALL: &[Layout] = &[
    crate::StageTimes::LAYOUT,
    crate::Identity::LAYOUT,
    crate::TargetType::LAYOUT,
    crate::Covariance::LAYOUT,
    crate::BatchHeader::LAYOUT,
    crate::SensorTrack::LAYOUT,
    crate::SensorDetection::LAYOUT,
    crate::SensorBearing::LAYOUT,
    crate::PlatformState::LAYOUT,
    crate::WideArea::LAYOUT,
    crate::Cue::LAYOUT,
    crate::Contribution::LAYOUT,
    crate::SystemTrack::LAYOUT,
    crate::Registration::LAYOUT,
    crate::Counters::LAYOUT,
    crate::Health::LAYOUT,
    crate::Progress::LAYOUT,
    crate::Control::LAYOUT,
];

/// Hash of every layout: what a batch carries so that a subscriber built otherwise refuses it.
pub const fn fingerprint() -> u64 {
    let mut hash = Fnv(0xcbf2_9ce4_8422_2325).number(crate::SCHEMA_VERSION as usize);
    let mut index = 0;
    while index < ALL.len() {
        hash = hash.text(ALL[index].name).number(ALL[index].size);
        let fields = ALL[index].fields;
        let mut field = 0;
        while field < fields.len() {
            let each = &fields[field];
            hash = hash
                .text(each.name)
                .text(each.kind)
                .number(each.offset)
                .number(each.size);
            field += 1;
        }
        index += 1;
    }
    hash.0
}

/// FNV-1a, the simplest hash that can run at compile time.
struct Fnv(u64);

impl Fnv {
    const fn byte(self, byte: u8) -> Self {
        Self((self.0 ^ byte as u64).wrapping_mul(0x0100_0000_01b3))
    }

    const fn text(mut self, text: &str) -> Self {
        let bytes = text.as_bytes();
        let mut index = 0;
        while index < bytes.len() {
            // `stringify!` may or may not put blanks into `[f64; 3]`: they carry no meaning.
            if bytes[index] != b' ' {
                self = self.byte(bytes[index]);
            }
            index += 1;
        }
        self.byte(0)
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

/// A field's type, split into element and count: `[f64; 3]` is (`f64`, 3).
fn element(kind: &str, layout: &Layout, field: &Field) -> (String, Option<usize>) {
    let Some(inner) = kind.strip_prefix('[').and_then(|rest| rest.strip_suffix(']')) else {
        return (kind.to_owned(), None);
    };
    let name = inner.split(';').next().unwrap_or_default().trim();
    let size = size_of_name(name).unwrap_or_else(|| panic!("{}.{}: unknown type {name}", layout.name, field.name));
    (name.to_owned(), Some(field.size / size))
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

/// The constants a reader in another language needs, by name.
fn constants() -> Vec<(String, u64, &'static str)> {
    use crate::{
        alert_bits, contribution_bits, identity_bits, platform_state_bits, registration_bits, sensor_bearing_bits,
        sensor_detection_bits, sensor_track_bits, wide_area_bits,
    };
    let mut list = vec![
        (
            "SCHEMA".to_owned(),
            fingerprint(),
            "Every BatchHeader.schema must equal this.",
        ),
        (
            "CONTRIBUTIONS_MAX".to_owned(),
            crate::CONTRIBUTIONS_MAX as u64,
            "Length of SystemTrack.contributions.",
        ),
        (
            "COUNTERS_MAX".to_owned(),
            crate::COUNTERS_MAX as u64,
            "Length of Counters.values.",
        ),
    ];
    let groups: [(&str, &[(&str, u64)]); 9] = [
        ("IDENTITY", identity_bits::NAMES),
        ("SENSOR_TRACK", sensor_track_bits::NAMES),
        ("SENSOR_DETECTION", sensor_detection_bits::NAMES),
        ("SENSOR_BEARING", sensor_bearing_bits::NAMES),
        ("PLATFORM_STATE", platform_state_bits::NAMES),
        ("WIDE_AREA", wide_area_bits::NAMES),
        ("CONTRIBUTION", contribution_bits::NAMES),
        ("ALERT", alert_bits::NAMES),
        ("REGISTRATION", registration_bits::NAMES),
    ];
    for (group, bits) in groups {
        for (name, bit) in bits {
            list.push((format!("{group}_{name}"), *bit, "Bit of a flags or valid field."));
        }
    }
    for state in crate::TrackState::ALL {
        list.push((
            format!("STATE_{}", state.word().to_uppercase()),
            state as u64,
            "Value of a state field.",
        ));
    }
    for kind in crate::TrackKind::ALL {
        list.push((
            format!("KIND_{}", kind.word().to_uppercase()),
            kind as u64,
            "Value of a track's kind field.",
        ));
    }
    list
}

/// The layouts as a C11 header, with its own static assertions.
pub fn c_header() -> String {
    let mut out = String::from(
        "/* Koseki's samples in shared memory. Written by `cargo run -p messages --example layouts`; a test keeps it true. */\n\
         #ifndef KOSEKI_MESSAGES_H\n#define KOSEKI_MESSAGES_H\n\n#include <assert.h>\n#include <stddef.h>\n#include <stdint.h>\n\n",
    );
    for (name, value, doc) in constants() {
        let _ = writeln!(out, "#define KOSEKI_{name} UINT64_C({value:#x}) /* {doc} */");
    }
    for layout in ALL {
        let _ = writeln!(out, "\ntypedef struct Koseki{} {{", layout.name);
        for field in layout.fields {
            let (element, count) = element(field.kind, layout, field);
            let count = count.map(|count| format!("[{count}]")).unwrap_or_default();
            let _ = writeln!(
                out,
                "    {} {}{count}; /*{} */",
                c_type(&element),
                field.name,
                field.doc
            );
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

/// The layouts as a Python module of `ctypes` structures that iceoryx2's Python package accepts.
pub fn python_module() -> String {
    let mut out = String::from(
        "\"\"\"Koseki's samples in shared memory, for ctypes and the iceoryx2 Python package.\n\n\
         Written by `cargo run -p messages --example layouts`; a test keeps it true.\n\"\"\"\n\nimport ctypes\n\n",
    );
    for (name, value, doc) in constants() {
        let _ = writeln!(out, "{name} = {value:#x}  # {doc}");
    }
    for layout in ALL {
        let _ = writeln!(out, "\n\nclass {}(ctypes.Structure):\n    _fields_ = [", layout.name);
        for field in layout.fields {
            let (element, count) = element(field.kind, layout, field);
            let count = count.map(|count| format!(" * {count}")).unwrap_or_default();
            let _ = writeln!(
                out,
                "        (\"{}\", {}{count}),  #{}",
                field.name,
                python_type(&element),
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

fn python_type(element: &str) -> String {
    match element {
        "f64" => "ctypes.c_double".to_owned(),
        "f32" => "ctypes.c_float".to_owned(),
        "u8" | "u16" | "u32" | "u64" => format!("ctypes.c_uint{}", &element[1..]),
        "i8" | "i16" | "i32" | "i64" => format!("ctypes.c_int{}", &element[1..]),
        sample => sample.to_owned(),
    }
}
