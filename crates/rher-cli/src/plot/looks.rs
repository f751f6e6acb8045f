//! Colors by meaning: a method with a preset, a sub-task or a part has the same one in every picture.
//!
//! They differ for every kind of color vision, after Okabe and Ito, and after Tol.

use super::chart::{Dash, Ink, Look};
use sha2::{Digest as _, Sha256};

/// What is compared most often.
const KNOWN: [(&str, Ink); 6] = [
    ("rher fast", [0x00, 0x72, 0xb2]),
    ("rher paper", [0xd5, 0x5e, 0x00]),
    ("rher sample-efficient", [0x00, 0x9e, 0x73]),
    ("her fast", [0xcc, 0x79, 0xa7]),
    ("her paper", [0xe6, 0x9f, 0x00]),
    ("her sample-efficient", [0x56, 0xb4, 0xe9]),
];

/// Anything else has one of these, by its name.
const OTHERS: [Ink; 8] = [
    [0x33, 0x22, 0x88],
    [0x44, 0xaa, 0x99],
    [0x11, 0x77, 0x33],
    [0x99, 0x99, 0x33],
    [0xcc, 0x66, 0x77],
    [0x88, 0x22, 0x55],
    [0xaa, 0x44, 0x99],
    [0x77, 0x55, 0x33],
];

/// Of the published curves.
const PUBLISHED: [(&str, Ink); 2] = [("rher", [0x55, 0x55, 0x55]), ("her", [0xaa, 0xaa, 0xaa])];

/// For each object: reaching it, and what is done with it.
const STAGES: [[Ink; 2]; 3] = [
    [[0x44, 0xaa, 0x99], [0x11, 0x77, 0x33]],
    [[0x66, 0x99, 0xcc], [0x00, 0x44, 0x88]],
    [[0xe0, 0x78, 0x8c], [0x99, 0x44, 0x55]],
];

/// The looks of groups that are compared with each other.
#[derive(Clone, Debug)]
pub(crate) struct Looks(Vec<Look>);

impl Looks {
    /// Of groups with these names. Where names share a color, the lines differ in their gaps.
    pub(crate) fn of(names: impl IntoIterator<Item = String>) -> Self {
        const DASHES: [Dash; 4] = [Dash::None, Dash::Long, Dash::Dots, Dash::LongAndDots];
        let mut looks: Vec<Look> = Vec::new();
        for name in names {
            if looks.iter().any(|known| known.name == name) {
                continue;
            }
            let ink = ink(&name);
            let before = looks.iter().filter(|known| known.ink == ink).count();
            looks.push(Look { name, ink, dash: DASHES[before % DASHES.len()] });
        }
        Self(looks)
    }

    /// That of the group with this name.
    pub(crate) fn get(&self, name: &str) -> Look {
        let known = self.0.iter().find(|look| look.name == name);
        known.cloned().unwrap_or_else(|| solid(name, ink(name)))
    }
}

/// The methods whose curves were published, and how they are drawn.
pub(super) fn published() -> impl Iterator<Item = (&'static str, Look)> {
    PUBLISHED.into_iter().map(|(method, ink)| {
        (method, Look { dash: Dash::Short, ..solid(&format!("{method}, published"), ink) })
    })
}

/// Of the sub-task with this index, two for each object.
pub(super) fn subtask(name: &str, index: usize) -> Look {
    solid(name, STAGES[index / 2 % STAGES.len()][index % 2])
}

/// Of the object with this index.
pub(super) fn object(name: &str, index: usize) -> Look {
    solid(name, STAGES[index % STAGES.len()][1])
}

/// Of anything else, by its name.
pub(super) fn named(name: &str) -> Look {
    solid(name, ink(name))
}

fn solid(name: &str, ink: Ink) -> Look {
    Look { name: name.to_owned(), ink, dash: Dash::None }
}

/// The same name has the same color in every picture.
fn ink(name: &str) -> Ink {
    let known = KNOWN.into_iter().find(|(known, _)| *known == name).map(|(_, ink)| ink);
    // The hashes of the standard library may change between versions.
    known.unwrap_or_else(|| OTHERS[usize::from(Sha256::digest(name)[0]) % OTHERS.len()])
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_name_keeps_its_color_whatever_is_beside_it() {
        let of = |names: &[&str], name: &str| {
            Looks::of(names.iter().map(|&name| name.to_owned())).get(name).ink
        };
        for name in ["rher fast", "her paper", "rher fast relay.mirror=0"] {
            let alone = of(&[name], name);
            assert_eq!(alone, of(&["rher paper", "rher fast relay.mirror=0.5", name], name));
        }
    }

    #[test]
    fn names_that_share_a_color_differ_in_their_gaps() {
        let names: Vec<String> =
            (0..10).map(|number| format!("rher fast relay.mirror=0.{number}")).collect();
        let Looks(looks) = Looks::of(names);
        for (index, look) in looks.iter().enumerate() {
            let same = |other: &&Look| (other.ink, other.dash) == (look.ink, look.dash);
            assert_eq!(looks[..index].iter().find(same), None, "{look:?}");
        }
    }
}
