//! Parts of a mesh that do not touch.

use super::simplices::Mesh;

impl<const D: usize, const N: usize> Mesh<D, N> {
    /// The part of each node; parts are numbered from 0 in the order of their first nodes.
    pub fn parts(&self) -> Vec<usize> {
        // Each node leads to a smaller one of its part, the smallest to itself.
        let mut leads: Vec<usize> = (0..self.node_count()).collect();
        let root = |leads: &[usize], mut node: usize| {
            while leads[node] != node {
                node = leads[node];
            }
            node
        };
        for nodes in &self.simplices {
            let roots = nodes.map(|node| root(&leads, node));
            let least = roots.into_iter().fold(usize::MAX, usize::min);
            for node in nodes.iter().chain(&roots) {
                leads[*node] = least;
            }
        }
        let mut part = vec![0; leads.len()];
        let mut count = 0;
        for node in 0..leads.len() {
            if leads[node] == node {
                part[node] = count;
                count += 1;
            } else {
                part[node] = part[leads[node]];
            }
        }
        part
    }
}
