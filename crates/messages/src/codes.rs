//! Enumerations and flag bits: one declaration gives each value a code, a word and a sentence.
//!
//! A code is part of the contract between processes and recordings. The declaration states the code beside the
//! name, and the code never changes, so inserted values have no effect on others. The C header and the Python
//! module take constants from the same declaration.

/// Value for other languages.
#[derive(Clone, Copy, Debug)]
pub struct Constant {
    /// Name of an enumeration's value in files, or of a bit in Rust.
    pub word: &'static str,
    /// Code or bit.
    pub value: u64,
    /// First line of the documentation.
    pub doc: &'static str,
}

/// Declares an enumeration with a word per value, and codes for messages.
///
/// ```
/// messages::codes! {
///     /// Kind of a fruit.
///     pub enum Fruit: u8 {
///         /// It grows on trees.
///         Apple = 3, "apple";
///     }
/// }
/// assert_eq!((Fruit::Apple.code(), Fruit::Apple.word()), (3, "apple"));
/// assert_eq!((Fruit::from_code(3), Fruit::from_word("pear")), (Some(Fruit::Apple), None));
///
/// messages::codes! {
///     /// Colour that is written in files only, and therefore has no code.
///     pub enum Colour {
///         /// Long waves.
///         Red, "red";
///     }
/// }
/// assert_eq!(Colour::ALL, [Colour::Red]);
/// ```
#[macro_export]
macro_rules! codes {
    (
        $(#[$attribute:meta])*
        $visibility:vis enum $name:ident $(: $code_type:ident)? $(, default $default:ident)? {
            $( $(#[doc = $doc:literal])+ $variant:ident $(= $code:literal)?, $word:literal; )+
        }
    ) => {
        $(#[$attribute])*
        #[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
        $( #[repr($code_type)] )?
        $visibility enum $name {
            $( $(#[doc = $doc])+ $variant $(= $code)?, )+
        }

        #[allow(dead_code, reason = "not every enumeration is both read and written")]
        impl $name {
            /// All values, in the order of declaration.
            $visibility const ALL: [Self; [$($word),+].len()] = [ $( Self::$variant, )+ ];

            /// Returns the word used in files, tables and command lines.
            $visibility const fn word(self) -> &'static str {
                match self { $( Self::$variant => $word, )+ }
            }

            /// Returns the value named by a word; `None` for an unknown word.
            $visibility fn from_word(word: &str) -> Option<Self> {
                Self::ALL.into_iter().find(|value| value.word() == word)
            }

            /// Returns the first line of the value's documentation.
            $visibility const fn doc(self) -> &'static str {
                match self { $( Self::$variant => [$($doc),+][0].trim_ascii(), )+ }
            }
        }

        $(
            impl Default for $name {
                fn default() -> Self {
                    Self::$default
                }
            }
        )?

        $crate::codes!(@code $name, $visibility, [$($code_type)?], $( $variant )+);
    };
    (@code $name:ident, $visibility:vis, [], $($variant:ident)+) => {};
    (@code $name:ident, $visibility:vis, [$code_type:ident], $($variant:ident)+) => {
        #[allow(dead_code, reason = "not every enumeration is both read and written")]
        impl $name {
            /// Returns the code used in messages.
            $visibility const fn code(self) -> $code_type {
                self as $code_type
            }

            /// Returns the value of a message's code; `None` for a code of a later version.
            $visibility fn from_code(code: $code_type) -> Option<Self> {
                Self::ALL.into_iter().find(|value| value.code() == code)
            }

            /// Returns the values for other languages.
            $visibility fn constants() -> Vec<$crate::Constant> {
                let constant = |value: Self| $crate::Constant {
                    word: value.word(),
                    value: u64::from(value.code()),
                    doc: value.doc(),
                };
                Self::ALL.into_iter().map(constant).collect()
            }
        }
    };
}

/// Declares the bits of a flags field, in a separate module.
macro_rules! bits {
    (
        $(#[doc = $about:literal])+
        $module:ident: $kind:ident {
            $( $(#[doc = $doc:literal])+ $name:ident = $bit:expr; )+
        }
    ) => {
        $(#[doc = $about])+
        pub mod $module {
            $( $(#[doc = $doc])+ pub const $name: $kind = $bit; )+

            pub(crate) const CONSTANTS: &[$crate::Constant] = &[ $( $crate::Constant {
                word: stringify!($name),
                value: $name as u64,
                doc: [$($doc),+][0].trim_ascii(),
            }, )+ ];
        }
    };
}
pub(crate) use bits;

#[cfg(test)]
mod tests {
    codes! {
        /// Sides of a coin.
        enum Side: u8 {
            /// Head up.
            /// A second line.
            Head = 2, "head";
            /// Tail up.
            Tail = 7, "tail";
        }
    }

    #[test]
    fn codes_and_words_name_values_and_nothing_else_does() {
        for side in Side::ALL {
            assert_eq!(Side::from_code(side.code()), Some(side));
            assert_eq!(Side::from_word(side.word()), Some(side));
        }
        assert_eq!((Side::from_code(0), Side::from_word("Head")), (None, None));
        assert_eq!((Side::Head.doc(), Side::constants()[1].value), ("Head up.", 7));
    }
}
