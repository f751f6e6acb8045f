//! A hand that slides along lines over a surface, and whether it is stopped.

use crate::support::{Stand, at_height};
use nalgebra::Vector3;
use rher_core::goal::Position;
use rher_envs::Simulated;

/// How far an action of 1 moves what nothing stops in a step, at least, in meters.
const FREE: f32 = 0.019;

/// Share of that which counts as stopped.
const STOPPED: f32 = 0.2;

/// Actions along the surface and towards it. With friction 1, a hand that presses as hard as it
/// pulls stays where it is.
pub(crate) const STROKES: [[f32; 2]; 7] =
    [[0.2, 0.02], [0.2, 0.05], [0.3, 0.05], [0.5, 0.05], [0.5, 0.1], [0.5, 0.2], [1.0, 0.1]];

/// Meters between parallel strokes.
const SPACING: f32 = 0.01;

/// How far a hand is above a surface before it presses on it, in meters.
const LIFT: f32 = 0.004;

/// How far from a surface what touches it is at most, in meters.
const TOUCHING: f32 = 0.0005;

/// Height at which a hand passes over everything, in meters.
pub(crate) const HIGH: f32 = 0.62;

/// What fingers do.
pub(crate) const OPEN: f32 = 1.0;
pub(crate) const CLOSE: f32 = -1.0;

/// Where the middle of what slides is while it touches a surface.
pub(crate) struct Track {
    /// Two opposite ones of a rectangle.
    corners: [Position; 2],
    /// Where the surface faces.
    out: Vector3<f32>,
}

impl Track {
    /// Of something with half edges `half`, over a surface with these corners.
    pub(crate) fn over(corners: [[f32; 3]; 2], out: [f32; 3], half: Vector3<f32>) -> Self {
        let out = Vector3::from(out);
        Self { corners: corners.map(|at| Position::from(at) + out.component_mul(&half)), out }
    }

    pub(crate) fn moved(self, by: Vector3<f32>) -> Self {
        Self { corners: self.corners.map(|corner| corner + by), ..self }
    }

    /// Beginnings and ends of parallel lines, in both directions of both axes, and the axis along
    /// which they are.
    fn lines(&self) -> Vec<([Position; 2], usize)> {
        let [low, high] = self.corners;
        let size = high - low;
        let axes: Vec<usize> = (0..3).filter(|axis| self.out[*axis] == 0.0).collect();
        let mut lines = Vec::new();
        for (along, aside) in [(axes[0], axes[1]), (axes[1], axes[0])] {
            let count = (size[aside] / SPACING).round().max(1.0);
            for line in 0..=count as usize {
                let mut ends = [low, high];
                for end in &mut ends {
                    end[aside] = low[aside] + size[aside] * line as f32 / count;
                }
                lines.push((ends, along));
                lines.push(([ends[1], ends[0]], along));
            }
        }
        lines
    }
}

/// How many strokes there were, how many of them touched the surface at their end, and which were
/// stopped.
#[derive(Default)]
pub(crate) struct Tally {
    pub(crate) surface: String,
    pub(crate) strokes: usize,
    pub(crate) touched: usize,
    pub(crate) stopped: Vec<String>,
}

impl Tally {
    pub(crate) fn check(&self) {
        let Self { surface, strokes, touched, stopped } = self;
        println!("{surface}: {} of {strokes} strokes stop, {touched} touched", stopped.len());
        assert!(
            stopped.is_empty(),
            "{surface}: {} of {strokes} stop:\n{stopped:#?}",
            stopped.len()
        );
        assert!(touched * 2 > *strokes, "{surface}: {touched} of {strokes} touched it");
    }
}

/// Slides the hand over a track in every direction, each time from the scene that there is.
pub(crate) fn slide<E: Simulated<N>, const N: usize>(
    stand: &mut Stand<E, N>,
    surface: &str,
    track: &Track,
    strokes: &[[f32; 2]],
) -> Tally {
    slide_where(stand, surface, track, strokes, |_, _| true)
}

/// The same along those lines that `goes` accepts, from where each begins and its axis.
pub(crate) fn slide_where<E: Simulated<N>, const N: usize>(
    stand: &mut Stand<E, N>,
    surface: &str,
    track: &Track,
    strokes: &[[f32; 2]],
    goes: impl Fn(Position, usize) -> bool,
) -> Tally {
    let (state, scene) = (stand.env.snapshot().unwrap(), stand.scene);
    let mut tally = Tally { surface: surface.to_owned(), ..Tally::default() };
    let lines = track.lines().into_iter().filter(|([from, _], along)| goes(*from, *along));
    for ([from, to], along) in lines {
        let lifted = from + track.out * LIFT;
        for [speed, press] in strokes {
            stand.env.return_to(&state).unwrap();
            stand.scene = scene;
            stand.go_to(at_height(lifted, HIGH), CLOSE);
            stand.go_to(lifted, CLOSE);
            let off = (stand.scene.gripper - lifted).norm();
            assert!(off < 0.004, "{surface}: {off} m from {lifted}, where a stroke begins");
            let towards = -track.out * *press;
            stand.repeat(2, [towards.x, towards.y, towards.z, CLOSE]);
            let mut along_it = Vector3::zeros();
            along_it[along] = (to - from)[along].signum() * speed;
            tally.strokes += 1;
            let stopped = stroke(stand, along_it, towards, to);
            let above = (stand.scene.gripper - to).dot(&track.out);
            tally.touched += usize::from(above < TOUCHING);
            if let Some(at) = stopped {
                tally.stopped.push(format!("{from} to {to} at {speed}, pressed {press}: at {at}"));
            }
        }
    }
    stand.env.return_to(&state).unwrap();
    stand.scene = scene;
    tally
}

/// Moves the hand along a surface until it is a step before `to`, and says where it is stopped.
pub(crate) fn stroke<E: Simulated<N>, const N: usize>(
    stand: &mut Stand<E, N>,
    along: Vector3<f32>,
    towards: Vector3<f32>,
    to: Position,
) -> Option<Position> {
    let (way, free) = (along.normalize(), FREE * along.norm());
    let [x, y, z]: [f32; 3] = (along + towards).into();
    stand.repeat(2, [x, y, z, CLOSE]);
    while (to - stand.scene.gripper).dot(&way) > 2.0 * free {
        let before = stand.scene.gripper;
        stand.step([x, y, z, CLOSE]);
        if (stand.scene.gripper - before).dot(&way) < STOPPED * free {
            return Some(stand.scene.gripper);
        }
    }
    None
}
