//! Which objects the numbers of an observation are about, and so what it is when they trade places.

use super::sink::{Sink, Subject};
use nalgebra::Vector3;
use rher_core::env::{Permutation, SignedIndex};
use rher_core::goal::Position;
use std::array;

/// A [`Sink`] that learns what the observation is about, number by number.
pub(crate) struct Owners {
    now: Subject,
    owners: Vec<Subject>,
}

/// An observation does not say which of its numbers belong to which of the objects that it calls
/// alike.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
#[error(
    "its objects are alike, so an observation has equally many numbers of each of them and of each \
     pair, but there are {first} of one and {other} of another: call `Sink::about` before each part"
)]
pub(crate) struct NotAlike {
    first: usize,
    other: usize,
}

impl Owners {
    pub(crate) fn new() -> Self {
        Self { now: Subject::Gripper, owners: Vec::new() }
    }

    /// Every other order of `N` objects, and what the observation is in it.
    ///
    /// Each object has the same numbers in the same order, and so has each two of them.
    ///
    /// # Errors
    ///
    /// If the objects do not own equally many numbers, at least one each, or if their pairs do not.
    pub(crate) fn permutations<const N: usize>(&self) -> Result<Vec<Permutation<N>>, NotAlike> {
        let of_objects = (0..N).map(|object| self.owned(Subject::Object(object)).count());
        let first = equal(of_objects)?;
        if first == 0 {
            return Err(NotAlike { first, other: 0 });
        }
        let pairs = (0..N).flat_map(|one| (one + 1..N).map(move |other| (one, other)));
        equal(pairs.map(|(one, other)| {
            let [there, back] = [Subject::Between(one, other), Subject::Between(other, one)];
            self.owned(there).count() + self.owned(back).count()
        }))?;
        let image = |order: [usize; N]| {
            let observation =
                (0..self.owners.len()).map(|index| self.image(index, &order)).collect();
            Permutation { order, observation }
        };
        Ok(orders::<N>().into_iter().skip(1).map(image).collect())
    }

    /// Where the numbers of `subject` are.
    fn owned(&self, subject: Subject) -> impl Iterator<Item = usize> {
        (0..self.owners.len()).filter(move |&index| self.owners[index] == subject)
    }

    fn image<const N: usize>(&self, index: usize, order: &[usize; N]) -> SignedIndex {
        let owner = self.owners[index];
        let place = self.owners[..index].iter().filter(|other| **other == owner).count();
        let (from, sign) = match owner {
            Subject::Gripper | Subject::Scenery(_) => (Some(index), 1.0),
            Subject::Object(object) => (self.owned(Subject::Object(order[object])).nth(place), 1.0),
            Subject::Between(one, other) => {
                let (one, other) = (order[one], order[other]);
                match self.owned(Subject::Between(one, other)).nth(place) {
                    Some(from) => (Some(from), 1.0),
                    None => (self.owned(Subject::Between(other, one)).nth(place), -1.0),
                }
            }
        };
        let from = from.expect("each object and each pair has equally many numbers");
        SignedIndex { from, sign, offset: 0.0 }
    }

    fn add(&mut self, numbers: usize) {
        self.owners.resize(self.owners.len() + numbers, self.now);
    }
}

/// The number that all `counts` are, 0 if there are none.
fn equal(mut counts: impl Iterator<Item = usize>) -> Result<usize, NotAlike> {
    let first = counts.next().unwrap_or(0);
    match counts.find(|count| *count != first) {
        Some(other) => Err(NotAlike { first, other }),
        None => Ok(first),
    }
}

/// Every order of `N` objects, the first being theirs.
fn orders<const N: usize>() -> Vec<[usize; N]> {
    let mut orders = vec![array::from_fn(|object| object)];
    for place in 0..N {
        orders = orders
            .iter()
            .flat_map(|order| {
                (place..N).map(|other| {
                    let mut order = *order;
                    order.swap(place, other);
                    order
                })
            })
            .collect();
    }
    orders
}

impl Sink for Owners {
    fn about(&mut self, about: Subject) {
        self.now = about;
    }

    fn position(&mut self, _: &str, _: Position) {
        self.add(3);
    }

    fn vector(&mut self, _: &str, _: Vector3<f32>) {
        self.add(3);
    }

    fn turn(&mut self, _: &str, _: Vector3<f32>) {
        self.add(3);
    }

    fn fingers(&mut self, _: &str, _: [f32; 2]) {
        self.add(2);
    }
}
