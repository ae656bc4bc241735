//! The declaration itself.

/// Declares tables of keys; the crate's page shows how.
#[macro_export]
macro_rules! settings {
    ($(
        $(#[doc = $doc:literal])*
        $(#[derive($($derived:ident),*)])?
        $vis:vis struct $name:ident $(beside [$($plain:ident : $plain_type:ty),+])? $(with $( $base:ident : $base_type:ty $(= $base_default:path)? ),+)? {
            $(check $check:path;)?
            $(
                $(#[doc = $key_doc:literal])+
                $field:ident $(as $key:literal)? : $type:ty
                $(= $default:expr)? $(, in $range:tt)? $(, usually $usually:literal)? ;
            )*
        }
    )*) => { $(
        $(#[doc = $doc])*
        #[derive(Clone, Debug, PartialEq $($(, $derived)*)?)]
        $vis struct $name {
            $( $(
                /// No key: it is made of other tables.
                pub $plain: $plain_type,
            )+ )?
            $( $(
                /// Keys that stand among its own.
                pub $base: $base_type,
            )+ )?
            $( $(#[doc = $key_doc])+ pub $field: $type, )*
        }

        impl Default for $name {
            fn default() -> Self {
                Self {
                    $( $( $plain: Default::default(), )+ )?
                    $( $( $base: $crate::or_default!($($base_default())?), )+ )?
                    $( $field: $crate::or_default!($($default)?), )*
                }
            }
        }

        impl $crate::KeyTable for $name {
            fn name(&self) -> &'static str {
                concat!(module_path!(), "::", stringify!($name))
            }

            fn doc(&self) -> &'static str {
                concat!($($doc),*)
            }

            fn keys(&self) -> Vec<&'static $crate::Key> {
                const KEYS: &[$crate::Key] = &[ $( $crate::Key {
                    name: $crate::first!($($key,)? stringify!($field)),
                    doc: concat!($($key_doc),+),
                    range: $crate::range!($($range)?),
                    usually: $crate::optional!($($usually)?),
                    is_required: $crate::is_nothing!($($default)?),
                }, )* ];
                KEYS.iter().collect()
            }

            fn values(&self) -> Vec<&dyn $crate::KeyValue> {
                vec![ $( &self.$field ),* ]
            }

            fn values_mut(&mut self) -> Vec<&mut dyn $crate::KeyValue> {
                vec![ $( &mut self.$field ),* ]
            }

            fn bases(&self) -> Vec<&dyn $crate::KeyTable> {
                vec![ $( $( &self.$base ),+ )? ]
            }

            fn bases_mut(&mut self) -> Vec<&mut dyn $crate::KeyTable> {
                vec![ $( $( &mut self.$base ),+ )? ]
            }

            fn check_together(&self) -> Result<(), $crate::SettingsError> {
                $( $check(self)?; )?
                Ok(())
            }
        }

        impl $crate::KeyValue for $name {
            fn read(
                &mut self,
                node: &$crate::Node<'_>,
                _: $crate::Range,
                at: &$crate::Place<'_>,
            ) -> Result<(), $crate::SettingsError> {
                $crate::read_table(self, node, at)
            }

            fn check(&self, _: $crate::Range, at: &$crate::Place<'_>) -> Result<(), $crate::SettingsError> {
                $crate::check_table(self, at)
            }

            fn kind(&self) -> String {
                "table".to_owned()
            }

            fn text(&self) -> String {
                String::new()
            }

            fn table(&self) -> Option<Box<dyn $crate::KeyTable>> {
                Some(Box::new(self.clone()))
            }
        }
    )* };
}

#[doc(hidden)]
#[macro_export]
macro_rules! or_default {
    () => {
        Default::default()
    };
    ($value:expr) => {
        $value
    };
}

#[doc(hidden)]
#[macro_export]
macro_rules! optional {
    () => {
        None
    };
    ($value:expr) => {
        Some($value)
    };
}

#[doc(hidden)]
#[macro_export]
macro_rules! first {
    ($first:expr $(, $other:expr)?) => {
        $first
    };
}

#[doc(hidden)]
#[macro_export]
macro_rules! is_nothing {
    () => {
        true
    };
    ($value:expr) => {
        false
    };
}

#[doc(hidden)]
#[macro_export]
macro_rules! range {
    () => {
        $crate::Range::Any
    };
    ([above $low:expr]) => {
        $crate::Range::Above($low as f64)
    };
    ([from $low:expr]) => {
        $crate::Range::From($low as f64)
    };
    ([$low:expr, $high:expr]) => {
        $crate::Range::Within($low as f64, $high as f64)
    };
}
