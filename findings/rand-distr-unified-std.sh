#!/usr/bin/env bash
# rand_distr 0.6.0: the bits of `StandardNormal` for one seed depend on what other crates of the
# program ask of num-traits. Without the feature `std` of num-traits, rand_distr takes exp and ln
# from the crate libm, and with it from the C library; features of a crate are united over the whole
# program, so that any dependency that asks for num-traits with its default features changes them.
#
# A good guess: `rand_distr` with `default-features = false` draws the same numbers in every program.
#
# Seen, hashes of 100 million draws on x86-64 with glibc 2.36:
#   rand_distr alone: 4942f411e524bacc
#   beside num-traits with default features: 5f820a3483d32b42
set -euo pipefail

folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
mkdir "$folder/src"
cat > "$folder/src/main.rs" <<'RUST'
use rand::{RngExt as _, SeedableRng as _};
use rand_distr::StandardNormal;

fn main() {
    let mut rng = rand_chacha::ChaCha8Rng::seed_from_u64(1);
    let mut hash = 0_u64;
    for _ in 0..100_000_000 {
        let draw: f64 = rng.sample(StandardNormal);
        hash = (hash ^ draw.to_bits()).wrapping_mul(0x9e37_79b9_7f4a_7c15).rotate_left(29);
    }
    println!("{hash:016x}");
}
RUST
draws() {
  cat > "$folder/Cargo.toml" <<TOML
[package]
name = "draws"
version = "0.0.0"
edition = "2024"

[dependencies]
rand = { version = "=0.10.3", default-features = false }
rand_chacha = { version = "=0.10.0", default-features = false }
rand_distr = { version = "=0.6.0", default-features = false }
$1
TOML
  cargo run --quiet --release --manifest-path "$folder/Cargo.toml"
}
alone=$(draws "")
beside=$(draws 'num-traits = "=0.2.19"')
echo "rand_distr alone: $alone"
echo "beside num-traits with default features: $beside"
if [ "$alone" = "$beside" ]; then
  echo "error: rand_distr behaves differently now" >&2
  exit 1
fi
