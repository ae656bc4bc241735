//! Choices that have words.

use crate::{Place, SettingsError};

/// Declares a choice: an enumeration whose variants have words, the first of them the default.
///
/// ```
/// settings::words! {
///     /// Motion that is assumed of an emitter.
///     pub enum Filter {
///         /// The data decide.
///         Auto = "auto",
///         /// It stands still.
///         Fixed = "fixed",
///     }
/// }
/// assert_eq!(Filter::from_word("fixed"), Some(Filter::Fixed));
/// assert_eq!(Filter::default().word(), "auto");
/// ```
#[macro_export]
macro_rules! words {
    ($(
        $(#[doc = $doc:literal])*
        $vis:vis enum $name:ident {
            $( $(#[doc = $variant_doc:literal])* $variant:ident = $word:literal ),* $(,)?
        }
    )*) => { $(
        $(#[doc = $doc])*
        #[derive(Clone, Copy, Debug, PartialEq, Eq)]
        $vis enum $name {
            $( $(#[doc = $variant_doc])* $variant, )*
        }

        #[allow(dead_code, reason = "a choice that only files make needs none of them")]
        impl $name {
            /// Every choice.
            $vis const ALL: [Self; <[&str]>::len(&[ $( $word ),* ])] = [ $( Self::$variant, )* ];

            /// The word for it.
            $vis const fn word(self) -> &'static str {
                match self {
                    $( Self::$variant => $word, )*
                }
            }

            /// The choice that `word` stands for; `None` if it stands for none.
            $vis fn from_word(word: &str) -> Option<Self> {
                match word {
                    $( $word => Some(Self::$variant), )*
                    _ => None,
                }
            }
        }

        impl Default for $name {
            /// The first one.
            fn default() -> Self {
                Self::ALL[0]
            }
        }

        impl $crate::Value for $name {
            fn read(
                &mut self,
                node: &$crate::Node<'_>,
                _: $crate::Range,
                at: &$crate::Place<'_>,
            ) -> Result<(), $crate::SettingsError> {
                let mut word = String::new();
                $crate::Value::read(&mut word, node, $crate::Range::Any, at)?;
                *self = Self::from_word(&word).ok_or_else(|| $crate::not_known(&word, &[ $( $word ),* ], at))?;
                Ok(())
            }

            fn check(&self, _: $crate::Range, _: &$crate::Place<'_>) -> Result<(), $crate::SettingsError> {
                Ok(())
            }

            fn kind(&self) -> String {
                [ $( concat!("\"", $word, "\"") ),* ].join(", ")
            }

            fn text(&self) -> String {
                format!("\"{}\"", self.word())
            }
        }
    )* };
}

/// The error of a word that stands for none of the choices.
pub fn not_known(word: &str, words: &[&str], at: &Place<'_>) -> SettingsError {
    at.error(format!("\"{word}\" is not known; there are: {}", words.join(", ")))
}
