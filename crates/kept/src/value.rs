//! Values as words of eight bytes, and back.

use messages::layout::Sample as _;
use messages::{Bias, BiasKind, Covariance, Identity, TargetType};

/// Value of a record.
pub trait Kept: Sized {
    /// Number of words of the value.
    const WORDS: usize;

    /// Writes the value.
    fn put(&self, to: &mut Put<'_>);

    /// Reads the value; `None` if the words are no such value.
    fn get(from: &mut Get<'_>) -> Option<Self>;
}

/// Words to write, and the place of the next word.
#[derive(Debug)]
pub struct Put<'a> {
    words: &'a mut [u64],
    at: usize,
}

impl<'a> Put<'a> {
    /// Starts at the first of `words`.
    #[inline]
    pub fn new(words: &'a mut [u64]) -> Self {
        Self { words, at: 0 }
    }

    /// Writes the next word.
    #[inline]
    pub fn word(&mut self, word: u64) {
        self.words[self.at] = word;
        self.at += 1;
    }
}

/// Words to read.
pub struct Get<'a>(pub &'a [u64]);

impl Get<'_> {
    /// Reads the next word; `None` at the end.
    pub fn word(&mut self) -> Option<u64> {
        let (first, rest) = self.0.split_first()?;
        self.0 = rest;
        Some(*first)
    }
}

/// Implements [`Kept`] for a struct: all fields, in the order of the declaration. The macro declares the struct, or
/// names the fields of a struct declared elsewhere; a missing field is then an error.
#[macro_export]
macro_rules! kept {
    ($(#[$meta:meta])* $vis:vis struct $name:ident {
        $($(#[$field_meta:meta])* $field_vis:vis $field:ident: $kind:ty),* $(,)?
    }) => {
        $(#[$meta])*
        $vis struct $name {
            $($(#[$field_meta])* $field_vis $field: $kind),*
        }
        $crate::kept!($name { $($field: $kind),* });
    };
    ($name:ty { $($field:ident: $kind:ty),* $(,)? }) => {
        impl $crate::Kept for $name {
            const WORDS: usize = 0 $(+ <$kind as $crate::Kept>::WORDS)*;

            #[inline]
            fn put(&self, to: &mut $crate::Put<'_>) {
                let Self { $($field),* } = self;
                $( <$kind as $crate::Kept>::put($field, to); )*
            }

            fn get(from: &mut $crate::Get<'_>) -> Option<Self> {
                Some(Self { $($field: <$kind as $crate::Kept>::get(from)?),* })
            }
        }
    };
}

/// Implements [`Kept`] for an enum without values: one word, the place of the variant in the list of all.
#[macro_export]
macro_rules! kept_variants {
    ($name:ident { $($variant:ident),* $(,)? }) => {
        impl $crate::Kept for $name {
            const WORDS: usize = 1;

            #[inline]
            fn put(&self, to: &mut $crate::Put<'_>) {
                let mut place = 0;
                $(
                    if matches!(self, Self::$variant) {
                        return to.word(place);
                    }
                    place += 1;
                )*
                // A variant that is not in the list does not compile.
                match self { $(Self::$variant)|* => to.word(place) }
            }

            fn get(from: &mut $crate::Get<'_>) -> Option<Self> {
                let place = usize::try_from(from.word()?).ok()?;
                [$(Self::$variant),*].into_iter().nth(place)
            }
        }
    };
}

/// Implements [`Kept`] for a number in one word.
macro_rules! number {
    ($($kind:ty, $value:ident => $put:expr, $word:ident => $get:expr;)*) => {
        $(impl Kept for $kind {
            const WORDS: usize = 1;

            #[inline]
            fn put(&self, to: &mut Put<'_>) {
                let $value = *self;
                to.word($put);
            }

            fn get(from: &mut Get<'_>) -> Option<Self> {
                let $word = from.word()?;
                $get
            }
        })*
    };
}

number! {
    u64, value => value, word => Some(word);
    i64, value => value.cast_unsigned(), word => Some(word.cast_signed());
    u32, value => u64::from(value), word => word.try_into().ok();
    u16, value => u64::from(value), word => word.try_into().ok();
    u8, value => u64::from(value), word => word.try_into().ok();
    usize, value => value as u64, word => word.try_into().ok();
    bool, value => u64::from(value), word => (word < 2).then_some(word == 1);
    i32, value => u64::from(value.cast_unsigned()), word => Some(u32::try_from(word).ok()?.cast_signed());
    f64, value => value.to_bits(), word => Some(f64::from_bits(word));
    f32, value => u64::from(value.to_bits()), word => Some(f32::from_bits(u32::try_from(word).ok()?));
    BiasKind, value => value as u64, word => BiasKind::from_code(word.try_into().ok()?);
}

impl<T: Kept, const N: usize> Kept for [T; N] {
    const WORDS: usize = N * T::WORDS;

    #[inline]
    fn put(&self, to: &mut Put<'_>) {
        for each in self {
            each.put(to);
        }
    }

    fn get(from: &mut Get<'_>) -> Option<Self> {
        let each: Option<Vec<T>> = (0..N).map(|_| T::get(from)).collect();
        each?.try_into().ok()
    }
}

impl<A: Kept, B: Kept> Kept for (A, B) {
    const WORDS: usize = A::WORDS + B::WORDS;

    #[inline]
    fn put(&self, to: &mut Put<'_>) {
        self.0.put(to);
        self.1.put(to);
    }

    fn get(from: &mut Get<'_>) -> Option<Self> {
        Some((A::get(from)?, B::get(from)?))
    }
}

impl<T: Kept> Kept for Option<T> {
    const WORDS: usize = 1 + T::WORDS;

    #[inline]
    fn put(&self, to: &mut Put<'_>) {
        self.is_some().put(to);
        match self {
            Some(value) => value.put(to),
            None => (0..T::WORDS).for_each(|_| to.word(0)),
        }
    }

    fn get(from: &mut Get<'_>) -> Option<Self> {
        if bool::get(from)? {
            return T::get(from).map(Some);
        }
        from.0 = from.0.get(T::WORDS..)?;
        Some(None)
    }
}

kept!(Covariance { upper: [f64; 21] });
kept!(Bias {
    kind: BiasKind,
    value: [f64; 2],
    partner: u16,
    is_certain: bool,
    is_removed: bool
});

/// Implements [`Kept`] for a sample by its bytes.
macro_rules! sample {
    ($($kind:ty),*) => {
        $(impl Kept for $kind {
            const WORDS: usize = size_of::<$kind>().div_ceil(8);

            #[inline]
            fn put(&self, to: &mut Put<'_>) {
                for octets in Self::octets(std::slice::from_ref(self)).as_chunks::<8>().0 {
                    to.word(u64::from_le_bytes(*octets));
                }
            }

            fn get(from: &mut Get<'_>) -> Option<Self> {
                let mut octets = [0; size_of::<$kind>()];
                for each in octets.as_chunks_mut::<8>().0 {
                    *each = from.word()?.to_le_bytes();
                }
                Self::of_octets(&octets)
            }
        }
        const _: () = assert!(size_of::<$kind>() % 8 == 0);)*
    };
}
sample!(Identity, TargetType);
