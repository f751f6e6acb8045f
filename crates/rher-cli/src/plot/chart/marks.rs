//! Lines, areas and words: all that a chart is made of.

/// Red, green and blue.
pub(crate) type Ink = [u8; 3];

pub(super) const BLACK: Ink = [0x22, 0x22, 0x22];
pub(super) const GRAY: Ink = [0x77, 0x77, 0x77];
pub(super) const PALE: Ink = [0xe4, 0xe4, 0xe4];

#[derive(Clone, Debug)]
pub(super) enum Mark {
    Stroke {
        points: Vec<[f32; 2]>,
        ink: Ink,
        width: f32,
        dashed: bool,
    },
    /// Closed, and seen through.
    Area {
        points: Vec<[f32; 2]>,
        ink: Ink,
    },
    Words {
        text: String,
        place: [f32; 2],
        anchor: Anchor,
        ink: Ink,
        bold: bool,
    },
}

/// Which end of words is at their place; vertically it is their base line.
#[derive(Clone, Copy, Debug)]
pub(super) enum Anchor {
    Start,
    Middle,
    End,
}

/// Opacity of an area.
pub(super) const AREA_OPACITY: f32 = 0.18;

/// Height of letters, in pixels, and how wide each is taken to be.
pub(super) const LETTER: f32 = 12.0;
pub(super) const LETTER_WIDTH: f32 = 7.2;

/// On and off, in pixels.
pub(super) const DASH: [f32; 2] = [5.0, 4.0];
