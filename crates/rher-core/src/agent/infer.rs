//! placeholder
use super::network::Shape;
/// placeholder
#[derive(Debug)]
pub struct Forward {
    shape: Shape,
    a: Vec<f32>,
    b: Vec<f32>,
}
impl Forward {
    /// x
    pub fn new(shape: &Shape) -> Self {
        let w =
            shape.hidden.iter().copied().max().unwrap_or(0).max(shape.inputs).max(shape.outputs);
        Self { shape: shape.clone(), a: vec![0.0; w], b: vec![0.0; w] }
    }
    /// x
    pub fn run(&mut self, p: &[f32], input: &[f32], _rows: usize) -> &[f32] {
        self.a[..input.len()].copy_from_slice(input);
        let layers = self.shape.layers();
        let last = layers.len() - 1;
        for (i, l) in layers.iter().enumerate() {
            let out = &mut self.b[..l.outputs];
            out.copy_from_slice(&p[l.bias.clone()]);
            for (x, w) in self.a[..l.inputs].iter().zip(p[l.weight.clone()].chunks_exact(l.outputs))
            {
                for (o, w) in out.iter_mut().zip(w) {
                    *o += x * w;
                }
            }
            if i != last {
                for o in out {
                    *o = o.max(0.0);
                }
            }
            std::mem::swap(&mut self.a, &mut self.b);
        }
        &self.a[..self.shape.outputs]
    }
}
