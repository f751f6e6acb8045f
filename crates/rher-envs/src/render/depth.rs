//! What is nearest, sample by sample.

/// The surface of a sample that nothing covers.
pub(super) const NONE: u32 = u32::MAX;

/// A corner of a polygon, in samples from the upper left, and how near it is: the larger the
/// nearer, linear over the polygon.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Corner {
    pub(super) x: f32,
    pub(super) y: f32,
    pub(super) nearness: f32,
}

/// The nearest surface of every sample.
pub(super) struct DepthBuffer {
    width: usize,
    height: usize,
    nearness: Vec<f32>,
    surface: Vec<u32>,
}

impl DepthBuffer {
    pub(super) fn new(width: usize, height: usize) -> Self {
        let samples = width * height;
        Self {
            width,
            height,
            nearness: vec![f32::NEG_INFINITY; samples],
            surface: vec![NONE; samples],
        }
    }

    pub(super) fn width(&self) -> usize {
        self.width
    }

    pub(super) fn height(&self) -> usize {
        self.height
    }

    pub(super) fn clear(&mut self) {
        self.nearness.fill(f32::NEG_INFINITY);
        self.surface.fill(NONE);
    }

    /// The nearest surface of a sample, and how near it is.
    pub(super) fn at(&self, x: usize, y: usize) -> (u32, f32) {
        let index = y * self.width + x;
        (self.surface[index], self.nearness[index])
    }

    /// Puts a convex polygon where it is nearer than what is there.
    pub(super) fn fill(&mut self, polygon: &[Corner], id: u32) {
        let Some(plane) = Plane::through(polygon) else { return };
        let rows = polygon.iter().map(|corner| corner.y);
        let top = rows.clone().fold(f32::INFINITY, f32::min);
        let bottom = rows.fold(f32::NEG_INFINITY, f32::max);
        for y in first_center(top, self.height)..first_center(bottom, self.height) {
            let middle = y as f32 + 0.5;
            let (left, right) = span(polygon, middle);
            let columns = first_center(left, self.width)..first_center(right, self.width);
            let start = y * self.width;
            let row = start + columns.start..start + columns.end;
            let mut nearness = plane.at(columns.start as f32 + 0.5, middle);
            let samples = self.nearness[row.clone()].iter_mut().zip(&mut self.surface[row]);
            for (nearest, surface) in samples {
                let is_nearer = nearness > *nearest;
                *nearest = if is_nearer { nearness } else { *nearest };
                *surface = if is_nearer { id } else { *surface };
                nearness += plane.along_x;
            }
        }
    }
}

/// Index of the first sample whose middle is not before `edge`, of `count`.
fn first_center(edge: f32, count: usize) -> usize {
    (edge - 0.5).ceil().clamp(0.0, count as f32) as usize
}

/// From where to where a row at height `y` is in a convex polygon.
fn span(polygon: &[Corner], y: f32) -> (f32, f32) {
    let mut ends = (f32::INFINITY, f32::NEG_INFINITY);
    let mut a = polygon[polygon.len() - 1];
    for &b in polygon {
        if (a.y <= y) != (b.y <= y) {
            let x = a.x + (y - a.y) / (b.y - a.y) * (b.x - a.x);
            ends = (ends.0.min(x), ends.1.max(x));
        }
        a = b;
    }
    ends
}

/// Nearness as a linear function of x and y.
struct Plane {
    origin: Corner,
    along_x: f32,
    along_y: f32,
}

impl Plane {
    /// None if the polygon is seen from its edge.
    fn through(polygon: &[Corner]) -> Option<Self> {
        const SMALLEST: f32 = 1e-4;
        let mut sum = [0.0; 3];
        let mut a = *polygon.last()?;
        for &b in polygon {
            sum[0] += (a.y - b.y) * (a.nearness + b.nearness);
            sum[1] += (a.nearness - b.nearness) * (a.x + b.x);
            sum[2] += (a.x - b.x) * (a.y + b.y);
            a = b;
        }
        let [x, y, area] = sum;
        (area.abs() > SMALLEST).then(|| Self {
            origin: polygon[0],
            along_x: -x / area,
            along_y: -y / area,
        })
    }

    fn at(&self, x: f32, y: f32) -> f32 {
        let Corner { x: from_x, y: from_y, nearness } = self.origin;
        nearness + (x - from_x) * self.along_x + (y - from_y) * self.along_y
    }
}
