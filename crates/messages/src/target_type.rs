//! Type of a track's target.

use crate::layout::sample;

/// Maximum number of characters of a type's name.
pub const TYPE_NAME_MAX: usize = 12;

sample! {
    /// Known type of a target (WA-9).
    TargetType, size 16 {
        /// Name in ASCII, padded with blanks.
        name: [u8; 12],
        /// Probability that it is of that type, in (0, 1]; 0 where no type is known.
        confidence: f32,
    }
}

impl TargetType {
    /// Creates a type with its probability; `None` if the name is empty, too long or not printable ASCII, or if the
    /// confidence is not in (0, 1].
    pub fn new(name: &str, confidence: f64) -> Option<Self> {
        let printable = |byte: &u8| (b' '..=b'~').contains(byte);
        let fits = name.len() <= TYPE_NAME_MAX && name.bytes().all(|byte| printable(&byte));
        let named = !name.trim().is_empty() && fits;
        let mut padded = [b' '; TYPE_NAME_MAX];
        (named && confidence > 0.0 && confidence <= 1.0).then(|| {
            padded[..name.len()].copy_from_slice(name.as_bytes());
            Self {
                name: padded,
                confidence: confidence as f32,
            }
        })
    }

    /// Whether a type is known, with a valid probability.
    pub fn is_known(&self) -> bool {
        self.confidence > 0.0 && self.confidence <= 1.0
    }

    /// Returns the name without padding, if a type is known.
    pub fn name(&self) -> Option<&str> {
        if !self.is_known() {
            return None;
        }
        let text = std::str::from_utf8(&self.name).ok()?.trim_end_matches([' ', '\0']);
        (!text.is_empty()).then_some(text)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_come_back_and_what_is_none_is_refused() {
        let known = TargetType::new("A320", 0.8).unwrap();
        assert_eq!((known.name(), known.confidence), (Some("A320"), 0.8));
        assert_eq!(TargetType::default().name(), None);
        for confidence in [0.0, -0.5, 1.5, f32::NAN] {
            let unlikely = TargetType { confidence, ..known };
            assert!(!unlikely.is_known() && unlikely.name().is_none());
        }
        assert!(TargetType::new("twelve chars", 1.0).is_some());
        for (name, confidence) in [
            ("", 0.5),
            (" ", 0.5),
            ("thirteen char", 0.5),
            ("é", 0.5),
            ("A", 0.0),
            ("A", 1.1),
            ("A", f64::NAN),
        ] {
            assert_eq!(TargetType::new(name, confidence), None, "{name} {confidence}");
        }
    }
}
