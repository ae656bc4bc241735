//! Names of this machine in requests.

/// Name of a machine in a configuration, without a port.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct HostName(String);

impl HostName {
    /// Returns the name in small letters, as [`Guard`](crate::Guard) compares names.
    pub fn in_small_letters(&self) -> String {
        self.0.to_ascii_lowercase()
    }

    fn parse(name: String) -> Result<Self, String> {
        let allowed = |letter: char| letter.is_ascii_alphanumeric() || letter == '-' || letter == '.';
        match !name.is_empty() && name.chars().all(allowed) {
            true => Ok(Self(name)),
            false => Err(format!(
                "\"{name}\" is no name of a machine; write it without a port, as in \"koseki.example\""
            )),
        }
    }
}

settings::spelt_as!(HostName, String, "text", Self::parse, |name| name.0.clone());
