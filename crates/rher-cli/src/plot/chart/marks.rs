//! Lines, areas, dots and words: all that a chart is made of.

/// Red, green and blue.
pub(crate) type Ink = [u8; 3];

pub(super) const BLACK: Ink = [0x22, 0x22, 0x22];
pub(super) const GRAY: Ink = [0x66, 0x66, 0x66];
pub(super) const PALE: Ink = [0xe4, 0xe4, 0xe4];

#[derive(Clone, Debug)]
pub(super) enum Mark {
    Stroke {
        points: Vec<[f32; 2]>,
        ink: Ink,
        width: f32,
        dash: Dash,
    },
    /// Closed, and seen through.
    Area {
        points: Vec<[f32; 2]>,
        ink: Ink,
    },
    Dot {
        center: [f32; 2],
        ink: Ink,
    },
    Words {
        text: String,
        place: [f32; 2],
        anchor: Anchor,
        ink: Ink,
        style: Style,
    },
    /// Text that a viewer shows while the pointer is over a rectangle.
    Hint {
        corner: [f32; 2],
        size: [f32; 2],
        text: String,
    },
}

/// Which end of words is at their place; vertically it is their base line.
#[derive(Clone, Copy, Debug)]
pub(super) enum Anchor {
    Start,
    Middle,
    End,
}

/// How words look.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Style {
    Plain,
    Bold,
    /// Bold and larger.
    Title,
}

/// Gaps in a line, by which lines of the same color are told apart.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Dash {
    None,
    Short,
    Long,
    Dots,
    LongAndDots,
}

impl Dash {
    /// On and off, in pixels.
    pub(super) const fn lengths(self) -> &'static [f32] {
        match self {
            Self::None => &[],
            Self::Short => &[5.0, 4.0],
            Self::Long => &[12.0, 4.0],
            Self::Dots => &[2.0, 3.0],
            Self::LongAndDots => &[10.0, 3.0, 2.0, 3.0],
        }
    }
}

impl Style {
    /// Height of letters, in pixels.
    pub(super) const fn size(self) -> f32 {
        match self {
            Self::Plain | Self::Bold => LETTER,
            Self::Title => 16.0,
        }
    }
}

/// Opacity of an area.
pub(super) const AREA_OPACITY: f32 = 0.18;

/// Height of letters, in pixels, and how wide each is taken to be.
pub(super) const LETTER: f32 = 12.0;
pub(super) const LETTER_WIDTH: f32 = 7.2;

/// Radius of a dot, in pixels.
pub(super) const DOT: f32 = 4.0;

/// A text that is not wider than this many pixels.
pub(super) fn fit(text: &str, width: f32) -> String {
    let most = (width / LETTER_WIDTH).max(4.0) as usize;
    if text.chars().count() <= most {
        return text.to_owned();
    }
    text.chars().take(most - 3).chain("...".chars()).collect()
}
