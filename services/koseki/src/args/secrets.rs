//! Tokens of a configuration: from its file or the environment, never from a command line.
//!
//! Every user of a machine can read the command lines of all processes, and nobody but its user the environment of a
//! process. The children of a launcher inherit the environment.

use offline::Usage;

/// Keys of tokens, and the variables that replace their values.
const TOKENS: [(&str, &str); 2] = [
    ("display.token", "KOSEKI_DISPLAY_TOKEN"),
    ("display.operator_token", "KOSEKI_DISPLAY_OPERATOR_TOKEN"),
];

/// Returns the replaced values of a configuration: those of the options, then those of the environment.
///
/// # Errors
/// If an option has a token.
pub(super) fn replaced(options: &[String], environment: impl Fn(&str) -> Option<String>) -> Result<Vec<String>, Usage> {
    for (key, variable) in TOKENS {
        let is_of_key = |option: &&String| option.split('=').next().is_some_and(|given| given.trim() == key);
        if options.iter().any(|option| is_of_key(&option)) {
            return Err(Usage(format!(
                "--set {key}: every user of this machine can read the command lines of all processes; write {key} into the \
                 file of the configuration (mode 600), or set {variable} in the environment"
            )));
        }
    }
    let given = TOKENS.into_iter().filter_map(|(key, variable)| {
        let token = environment(variable).filter(|token| !token.is_empty())?;
        Some(format!("{key}={}", serde_json::Value::from(token)))
    });
    Ok(options.iter().cloned().chain(given).collect())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn tokens_come_from_the_environment_and_not_from_options() {
        let environment = |variable: &str| (variable == "KOSEKI_DISPLAY_TOKEN").then(|| "0123456789abcdef".to_owned());
        let options = ["fusion.core=1".to_owned()];
        assert_eq!(
            replaced(&options, environment).unwrap(),
            ["fusion.core=1", "display.token=\"0123456789abcdef\""]
        );
        assert_eq!(replaced(&options, |_| Some(String::new())).unwrap(), options);
        for (key, variable) in TOKENS {
            for option in [
                format!("{key}=\"0123456789abcdef\""),
                format!(" {key} = \"0123456789abcdef\""),
            ] {
                let said = replaced(&[option], |_| None).unwrap_err().0;
                assert!(said.contains(variable) && !said.contains("0123456789abcdef"), "{said}");
            }
        }
    }
}
