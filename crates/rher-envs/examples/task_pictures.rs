//! Draws every task on one sheet.
//!
//! ```console
//! $ cargo run --release -p rher-envs --example task_pictures -- tasks.png
//! ```
//!
//! A second argument is the name of a camera, such as `side`, and a third one the seed of the episode
//! whose beginning is shown.

use rher_core::env::EnvError;
use rher_envs::render::{Image, Renderer, Viewpoint, scene};
use rher_envs::{EnvVisitor, Simulated, Task};
use std::error::Error;
use std::num::NonZeroU16;

/// Width and height of the picture of a task, in pixels.
const SIZE: [u16; 2] = [300, 225];

/// Tasks in a row.
const COLUMNS: usize = 5;

/// Draws how an episode begins.
struct Beginning {
    seed: u64,
    viewpoint: Viewpoint,
    size: [NonZeroU16; 2],
}

impl EnvVisitor for Beginning {
    type Output = Result<Image, EnvError>;

    fn visit<const N: usize, E: Simulated<N>>(self, build: impl Fn() -> E + Sync) -> Self::Output {
        let mut env = build();
        let mut observation = vec![0.0; env.spec().obs_dim];
        let start = env.reset(self.seed, &mut observation)?;
        let camera = self.viewpoint.camera(&mut env, &start)?;
        let things = scene(&mut env, &start.achieved, &start.desired);
        Ok(Renderer::new(self.size).draw(&camera, &things))
    }
}

fn main() -> Result<(), Box<dyn Error>> {
    let mut arguments = std::env::args().skip(1);
    let path = arguments.next().ok_or("expected a file to write, such as `tasks.png`")?;
    let name = arguments.next().unwrap_or_else(|| Viewpoint::default().name().to_owned());
    let viewpoint =
        Viewpoint::named(&name).ok_or_else(|| format!("no camera is called `{name}`"))?;
    let seed = arguments.next().map_or(Ok(3), |seed| seed.parse())?;

    let size = SIZE.map(|pixels| NonZeroU16::new(pixels).expect("not 0"));
    let [width, height] = SIZE.map(usize::from);
    let rows = Task::ALL.len().div_ceil(COLUMNS);
    let mut sheet = Image {
        width: COLUMNS * width,
        height: rows * height,
        rgb: vec![0xff; 3 * COLUMNS * width * rows * height],
    };
    for (index, task) in Task::ALL.iter().enumerate() {
        let mut image = task.visit(Beginning { seed, viewpoint, size })?;
        image.caption(&[(task.name(), [0xff; 3])]);
        let corner = [index % COLUMNS * width, index / COLUMNS * height];
        for (row, pixels) in image.rgb.chunks_exact(3 * width).enumerate() {
            let start = 3 * ((corner[1] + row) * sheet.width + corner[0]);
            sheet.rgb[start..start + pixels.len()].copy_from_slice(pixels);
        }
    }
    std::fs::write(path, sheet.png()?)?;
    Ok(())
}
