//! Words in the texts that strangers read first: C headers, Python docstrings, pages of help.
//!
//! A sentence whose nouns are pronouns has to be read twice. The words of two families are counted; well-liked
//! libraries have two of the first and twenty of the second in a thousand words.

use crate::common::{repository, texts};

const WHAT: [&str; 7] = ["what", "who", "whoever", "whatever", "whose", "whom", "whichever"];
const IT: [&str; 9] = ["it", "its", "they", "their", "them", "those", "ones", "one", "theirs"];
/// Most words of each family in a thousand.
const MOST: [f64; 2] = [2.5, 25.0];
/// Shorter texts have a word of their own at most.
const WORDS_MIN: usize = 100;

/// Words of both families in a thousand of a text's, and the number of its words.
fn families(text: &str) -> ([f64; 2], usize) {
    let words = text.split(|character: char| !character.is_ascii_alphabetic() && character != '\'');
    let words: Vec<String> = words.filter(|word| !word.is_empty()).map(str::to_lowercase).collect();
    let of = |family: &[&str]| words.iter().filter(|word| family.contains(&word.as_str())).count();
    let share = |count: usize| 1000.0 * count as f64 / words.len().max(1) as f64;
    ([share(of(&WHAT)), share(of(&IT))], words.len())
}

/// Fails where a text has too many words of a family.
pub(crate) fn assert_plain(place: &str, text: &str) {
    let (found, words) = families(text);
    let is_plain = words < WORDS_MIN || (0..2).all(|family| found[family] <= MOST[family]);
    assert!(
        is_plain,
        "{place}: {found:.1?} of {words} words are of the families of \"what\" and \"it\" per thousand, at most {MOST:?}"
    );
}

/// What stands between `begin` and `end`, all of it together.
fn between(text: &str, begin: &str, end: &str) -> String {
    let mut parts = text.split(begin).skip(1);
    let mut found = String::new();
    while let Some(part) = parts.next() {
        found += part.split(end).next().unwrap_or_default();
        found.push('\n');
        // The same mark ends a docstring: what follows it is code.
        if begin == end {
            parts.next();
        }
    }
    found
}

#[test]
fn headers_and_docstrings_are_plain() {
    let mut files = 0;
    for (path, text) in texts(&["h", "hpp", "py"]) {
        let is_public = path.starts_with("c/include/") || path.starts_with("python/koseki/");
        if !is_public {
            continue;
        }
        files += 1;
        let prose = match path.ends_with(".py") {
            true => between(&text, "\"\"\"", "\"\"\"") + &between(&text, "# ", "\n"),
            false => between(&text, "/*", "*/") + &between(&text, "// ", "\n"),
        };
        assert_plain(&path, &prose);
    }
    assert!(files >= 6 && repository("c/include").is_dir(), "{files} files");
}

#[test]
fn words_are_counted_by_their_families() {
    let (found, words) = families("What it is worth, and whose: they say it's theirs; the one's own. a a a a a a a");
    // "it's" and "one's" are words of their own.
    assert_eq!(
        (words, found.map(|share| (share * words as f64 / 1000.0).round())),
        (20, [2.0, 3.0])
    );
    assert_eq!(between("a /* b */ c /* d */", "/*", "*/"), " b \n d \n");
    assert_eq!(
        between("x = \"\"\"doc\"\"\" y \"\"\"more\"\"\"", "\"\"\"", "\"\"\""),
        "doc\nmore\n"
    );
}
