//! Acting: 31 numbers in, three layers of 256, 4 out, for one environment and for sixteen.

use criterion::{Criterion, criterion_group, criterion_main};
use rher_core::learner::infer::Inference;
use rher_core::learner::network::Shape;
use std::hint::black_box;

fn infer(criterion: &mut Criterion) {
    let shape = Shape { inputs: 31, hidden: vec![256; 3], outputs: 4, layer_norm: false };
    let parameters = vec![0.01; shape.parameters()];
    let mut inference = Inference::new(&shape);
    let mut group = criterion.benchmark_group("infer");
    for rows in [1, 16] {
        let inputs = vec![0.5; rows * shape.inputs];
        let mut actions = vec![0.0; rows * shape.outputs];
        group.bench_function(rows.to_string(), |bencher| {
            bencher.iter(|| inference.act(&parameters, black_box(&inputs), &mut actions));
        });
    }
}

criterion_group!(benches, infer);
criterion_main!(benches);
