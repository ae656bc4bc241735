//! Choices that have words.

/// Declares a choice: an enumeration with a word per variant; the first variant is the default.
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

        $crate::spelt_as!(
            $name,
            String,
            [ $( concat!("\"", $word, "\"") ),* ].join(", "),
            |word| Self::from_word(&word).ok_or_else(|| $crate::not_known(&word, &[ $( $word ),* ])),
            |choice| choice.word().to_owned()
        );
    )* };
}

/// A sentence on a word that stands for none of the choices.
pub fn not_known(word: &str, words: &[&str]) -> String {
    format!("\"{word}\" is not known; there are: {}", words.join(", "))
}
