//! Paths as a shell takes them.

use std::path::Path;

/// A path as one word of a command line, in quotes where a shell would otherwise take it apart.
pub(crate) fn word(path: &Path) -> String {
    let path = path.display().to_string();
    let is_plain = |c: char| c.is_alphanumeric() || "-_./=+,@:%".contains(c);
    if !path.is_empty() && path.chars().all(is_plain) {
        return path;
    }
    format!("'{}'", path.replace('\'', r"'\''"))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn paths_are_quoted_where_a_shell_would_take_them_apart() {
        for (path, expected) in [
            ("runs/push-rher-fast-1", "runs/push-rher-fast-1"),
            ("runs/relay.mirror=0", "runs/relay.mirror=0"),
            ("my run", "'my run'"),
            ("agent.hidden=[16]", "'agent.hidden=[16]'"),
            ("it's", r"'it'\''s'"),
        ] {
            assert_eq!(word(Path::new(path)), expected);
        }
    }
}
