#!/usr/bin/env bash
# clap_complete 4.6.11: the values that a positional argument may have are completed in bash and in
# zsh, and not in fish. The script for fish has the values of options, and the names of commands, but
# not one of a positional argument's, which are in the description of the same command.
#
# A good guess: the three scripts are made from one description, and complete the same words.
#
# Seen:
#   bash: value of the option 1, value of the positional argument 1
#   zsh: value of the option 1, value of the positional argument 1
#   fish: value of the option 1, value of the positional argument 0
set -euo pipefail

folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
mkdir "$folder/src"
cat > "$folder/Cargo.toml" <<'TOML'
[package]
name = "shells"
version = "0.0.0"
edition = "2024"

[dependencies]
clap = "=4.6.7"
clap_complete = "=4.6.11"
TOML
cat > "$folder/src/main.rs" <<'RUST'
use clap::{Arg, Command};
use clap_complete::{Shell, generate};

fn main() {
    for shell in [Shell::Bash, Shell::Zsh, Shell::Fish] {
        let train = Command::new("train")
            .arg(Arg::new("task").value_parser(["stacking"]))
            .arg(Arg::new("preset").long("preset").value_parser(["sparing"]));
        let mut script = Vec::new();
        generate(shell, &mut Command::new("robot").subcommand(train), "robot", &mut script);
        let script = String::from_utf8(script).unwrap();
        let has = |value: &str| usize::from(script.contains(value));
        println!(
            "{shell}: value of the option {}, value of the positional argument {}",
            has("sparing"),
            has("stacking")
        );
    }
}
RUST
seen=$(cd "$folder" && cargo run --quiet --release)
echo "$seen"
diff <(grep '^#   ' "$0" | sed 's/^#   //') <(echo "$seen")
