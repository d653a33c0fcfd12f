//! Multifrontal LU on fronts of nodes, N unknowns a node.
//!
//! ```text
//!   front   ⎡F11 F12⎤   pivots       F11 = L11 U11         no exchanges (eliminate)
//!           ⎣F21 F22⎦   boundary     L21 = F21 U11⁻¹,  U12 = L11⁻¹ F12
//!                                    F22 ← F22 − L21 U12   handed to the parent
//! ```
//!
//! After Duff and Reid (1983). Rows are not exchanged; what that costs in accuracy the iterative refinement of the
//! caller repairs. A pivot that is too small is told. Fronts are computed one by one in a fixed order or, subtree
//! by subtree, on several threads: the numbers are the same.

use std::sync::{Arc, Mutex};

use super::eliminate::{Parts, Precision, Shape};
use super::pattern;
use super::plans::{Plan, Plans, Run};
use super::substitution::Solve;
use crate::wide::{Task, Wide};

/// Subtrees and fronts with fewer operations are not worth another thread.
const SHARED: f64 = 4e6;

/// Structure and numbers of the factor.
pub struct Multifrontal<T, const N: usize> {
    plans: Arc<Plans<N>>,
    /// L11\U11 over L21 of all fronts: all rows, pivot columns.
    left: Vec<T>,
    /// U12 of all fronts: pivot rows, boundary columns.
    top: Vec<T>,
    /// Were all pivots large enough?
    trusted: bool,
    /// Buffers of the threads.
    workspaces: Mutex<Vec<Workspace<T>>>,
}

/// Numbers of a front that is being computed, column by column.
struct Numbers<'a, T> {
    left: &'a mut [T],
    top: &'a mut [T],
    /// F22, until the parent takes it.
    rest: Vec<T>,
    /// Were its pivots large enough?
    trusted: bool,
}

/// Buffers that outlive a front.
struct Workspace<T> {
    spare: Vec<Vec<T>>,
    room: Vec<T>,
}

impl<T: Precision, const N: usize> Multifrontal<T, N> {
    /// On this structure.
    pub fn new(plans: Arc<Plans<N>>) -> Self {
        let shapes = || plans.fronts.iter().map(|plan| &plan.shape);
        let left = shapes().map(Shape::left_length).sum();
        let top = shapes().map(Shape::top_length).sum();
        Multifrontal {
            left: vec![T::default(); left],
            top: vec![T::default(); top],
            trusted: false,
            workspaces: Mutex::default(),
            plans,
        }
    }

    /// Factorise the matrix with these blocks, on the threads of the present pool.
    pub fn factorise(&mut self, values: &[pattern::Block<N>]) {
        let (mut left, mut top) = (&mut self.left[..], &mut self.top[..]);
        let mut numbers: Vec<Numbers<'_, T>> = Vec::with_capacity(self.plans.fronts.len());
        for Plan { shape, .. } in &self.plans.fronts {
            let (own_left, later_left) = left.split_at_mut(shape.left_length());
            let (own_top, later_top) = top.split_at_mut(shape.top_length());
            (left, top) = (later_left, later_top);
            numbers.push(Numbers {
                left: own_left,
                top: own_top,
                rest: Vec::new(),
                trusted: false,
            });
        }
        let factorisation = Factorisation {
            plans: &self.plans.fronts,
            values,
            workspaces: &self.workspaces,
            wide: Wide::here(),
            shared: rayon::current_num_threads() > 1,
        };
        for &root in &self.plans.roots {
            let first = self.plans.fronts[root].front.first;
            factorisation.subtree(&mut numbers[first..=root], first);
        }
        self.trusted = numbers.iter().all(|numbers| numbers.trusted);
    }

    /// Were all pivots of the last matrix large enough?
    pub fn is_trusted(&self) -> bool {
        self.trusted
    }

    /// x ← (LU)⁻¹ x
    pub fn solve(&self, x: &mut [f64]) {
        let mut rounded: Vec<T> = x.iter().map(|value| T::of(*value).flushed()).collect();
        Wide::here().run(Solve {
            plans: &self.plans,
            left: &self.left,
            top: &self.top,
            x: &mut rounded,
        });
        for (x, value) in x.iter_mut().zip(rounded) {
            *x = value.to_f64();
        }
    }
}

impl<T: Precision> Workspace<T> {
    /// A spare buffer of so many numbers at least, the smallest one: what is in it has no meaning.
    fn buffer(&mut self, length: usize) -> Vec<T> {
        let spare = self.spare.iter().enumerate();
        let fitting = spare.filter(|(_, buffer)| buffer.len() >= length);
        match fitting.min_by_key(|(_, buffer)| buffer.len()) {
            Some((k, _)) => self.spare.swap_remove(k),
            None => vec![T::default(); length],
        }
    }
}

/// What fronts are computed from.
struct Factorisation<'a, T, const N: usize> {
    plans: &'a [Plan<N>],
    values: &'a [pattern::Block<N>],
    workspaces: &'a Mutex<Vec<Workspace<T>>>,
    wide: Wide,
    shared: bool,
}

impl<T: Precision, const N: usize> Factorisation<'_, T, N> {
    /// Factorise a subtree; `base` is the number of its first front.
    fn subtree(&self, numbers: &mut [Numbers<'_, T>], base: usize) {
        let root = base + numbers.len() - 1;
        if !self.shared || self.plans[root].operations < SHARED {
            let mut workspace = self.workspace();
            for k in 0..numbers.len() {
                self.front(&mut numbers[..=k], base, &mut workspace);
            }
            return self.give_back(workspace);
        }
        self.children(
            &mut numbers[..root - base],
            base,
            &self.plans[root].front.children,
        );
        let mut workspace = self.workspace();
        self.front(numbers, base, &mut workspace);
        self.give_back(workspace);
    }

    /// Factorise the subtrees of some children, which lie one after the other from front `base` on.
    fn children(&self, numbers: &mut [Numbers<'_, T>], base: usize, children: &[usize]) {
        match children {
            [] => {}
            [_] => self.subtree(numbers, base),
            _ => {
                let (low, high) = children.split_at(self.half(children));
                let split = low.last().map_or(0, |&last| last + 1 - base);
                let (first, second) = numbers.split_at_mut(split);
                rayon::join(
                    || self.children(first, base, low),
                    || self.children(second, base + split, high),
                );
            }
        }
    }

    /// Where children are cut into halves of about as many operations, none of which is empty.
    fn half(&self, children: &[usize]) -> usize {
        let operations = |&child: &usize| self.plans[child].operations;
        let all: f64 = children.iter().map(operations).sum();
        let mut before = 0.0;
        for (k, child) in children.iter().enumerate() {
            let own = operations(child);
            if before + own / 2.0 > all / 2.0 {
                return k.clamp(1, children.len() - 1);
            }
            before += own;
        }
        children.len() - 1
    }

    /// Buffers that nobody uses.
    fn workspace(&self) -> Workspace<T> {
        let mut free = self.workspaces.lock().unwrap_or_else(|e| e.into_inner());
        free.pop().unwrap_or_else(|| Workspace {
            spare: Vec::new(),
            room: Vec::new(),
        })
    }

    fn give_back(&self, workspace: Workspace<T>) {
        let mut free = self.workspaces.lock().unwrap_or_else(|e| e.into_inner());
        free.push(workspace);
    }

    /// Assemble and eliminate the last front of `numbers`; `base` is the number of the first.
    fn front(&self, numbers: &mut [Numbers<'_, T>], base: usize, workspace: &mut Workspace<T>) {
        let k = base + numbers.len() - 1;
        let plan = &self.plans[k];
        let (done, last) = numbers.split_at_mut(numbers.len() - 1);
        let own = &mut last[0];
        own.rest = workspace.buffer(plan.shape.rest_length());
        self.wide.run(Assembly {
            plan,
            own: &mut *own,
            values: self.values,
        });
        let children = || plan.front.children.iter().zip(&plan.runs);
        let add = |own: &mut Numbers<'_, T>, is_rest| {
            for (&child, runs) in children() {
                let rest = &done[child - base].rest;
                self.wide.run(Child {
                    own: &mut *own,
                    parent: plan.shape,
                    child: self.plans[child].shape,
                    runs,
                    rest,
                    is_rest,
                });
            }
        };
        add(own, false);
        let parts = Parts {
            shape: plan.shape,
            left: own.left,
            top: own.top,
            rest: &mut own.rest,
            room: &mut workspace.room,
            shared: self.shared,
        };
        own.trusted = T::eliminate(self.wide, parts);
        add(own, true);
        for &child in &plan.front.children {
            workspace
                .spare
                .push(std::mem::take(&mut done[child - base].rest));
        }
        if plan.front.boundary.is_empty() {
            workspace.spare.push(std::mem::take(&mut own.rest));
        }
    }
}

/// The blocks of the matrix come to a front.
struct Assembly<'a, 'b, T, const N: usize> {
    plan: &'a Plan<N>,
    own: &'a mut Numbers<'b, T>,
    values: &'a [pattern::Block<N>],
}

impl<T: Precision, const N: usize> Task for Assembly<'_, '_, T, N> {
    type Output = ();

    #[inline(always)]
    fn run(self) {
        let Assembly { plan, own, values } = self;
        own.left.fill(T::default());
        own.top.fill(T::default());
        for source in &plan.blocks {
            let (row, column) = (N * source.row as usize, N * source.column as usize);
            let values = &values[source.number as usize];
            let (target, stride) = own.column(plan.shape, column, row);
            for f in 0..N {
                let target = &mut target[f * stride..][..N];
                for d in 0..N {
                    target[d] = T::of(values[f][d]).flushed();
                }
            }
        }
    }
}

/// What a child left over is added, before pivots are eliminated or, to the rest, after that.
struct Child<'a, 'b, T> {
    own: &'a mut Numbers<'b, T>,
    parent: Shape,
    child: Shape,
    runs: &'a [Run],
    rest: &'a [T],
    /// What comes to the rest of the parent, or everything else.
    is_rest: bool,
}

impl<T: Precision> Task for Child<'_, '_, T> {
    type Output = ();

    #[inline(always)]
    fn run(self) {
        let Child {
            own,
            parent,
            child,
            runs,
            rest,
            is_rest,
        } = self;
        let mut first = 0;
        while first < runs.len() && (runs[first].to as usize) < parent.pivots {
            first += 1;
        }
        let begin = if is_rest { first } else { 0 };
        for k in begin..runs.len() {
            let columns = runs[k];
            // runs ascend, so those before `first` come to pivots
            let end = if is_rest || k < first {
                runs.len()
            } else {
                first
            };
            for rows in &runs[begin..end] {
                let (column, row) = (columns.to as usize, rows.to as usize);
                let (target, stride) = own.column(parent, column, row);
                let from = columns.from as usize * child.rest + rows.from as usize;
                let (rest, length) = (&rest[from..], rows.length as usize);
                for c in 0..columns.length as usize {
                    let values = &rest[c * child.rest..][..length];
                    let target = &mut target[c * stride..][..length];
                    for k in 0..length {
                        target[k] += values[k];
                    }
                }
            }
        }
    }
}

impl<T> Numbers<'_, T> {
    /// A front from row `row` of column `column` on, in the part that holds both, and how far its columns are apart.
    #[inline(always)]
    fn column(&mut self, shape: Shape, column: usize, row: usize) -> (&mut [T], usize) {
        let p = shape.pivots;
        if column < p {
            (&mut self.left[column * shape.left + row..], shape.left)
        } else if row < p {
            (&mut self.top[(column - p) * shape.top + row..], shape.top)
        } else {
            let from = (column - p) * shape.rest + row - p;
            (&mut self.rest[from..], shape.rest)
        }
    }
}
