//! The nodes of the tree.

/// Children of a node.
pub(crate) const WIDTH: usize = 8;

/// The bit of a child's number that marks an object.
pub(crate) const LEAF: u32 = 1 << 31;

/// Rounding, here and in the kernel, is less than this share of distances and sizes.
pub(crate) const CONSERVATIVE: f32 = 2e-6;

// No load of eight lanes crosses a cache line.
#[derive(Clone, Debug)]
#[repr(align(32))]
pub(crate) struct Node {
    /// The bounding sphere of each child. A missing child has a radius of -inf, which no cone intersects.
    pub(crate) x: [f32; WIDTH],
    pub(crate) y: [f32; WIDTH],
    pub(crate) z: [f32; WIDTH],
    pub(crate) radius: [f32; WIDTH],
    pub(crate) child: [u32; WIDTH],
}

impl Node {
    pub(crate) fn empty() -> Node {
        Node {
            x: [0.0; WIDTH],
            y: [0.0; WIDTH],
            z: [0.0; WIDTH],
            radius: [f32::NEG_INFINITY; WIDTH],
            child: [0; WIDTH],
        }
    }

    /// Put a child's bounding sphere and its number into its place.
    #[inline(always)]
    pub(crate) fn put(&mut self, i: usize, (center, radius): ([f32; 3], f32), child: u32) {
        self.child[i] = child;
        [self.x[i], self.y[i], self.z[i]] = center;
        let away = (center[0] * center[0] + center[1] * center[1] + center[2] * center[2]).sqrt();
        self.radius[i] = (radius + away * CONSERVATIVE) * (1.0 + CONSERVATIVE);
    }

    /// Return the centre of a child relative to an apex, and its radius with the rounding of both: a share of their
    /// distance, and `slack`.
    #[inline(always)]
    pub(crate) fn child_from(&self, apex: [f32; 3], slack: f32, i: usize) -> ([f32; 3], f32) {
        let [x, y, z] = [self.x[i] - apex[0], self.y[i] - apex[1], self.z[i] - apex[2]];
        ([x, y, z], self.radius[i] + (slack + CONSERVATIVE * (x.abs() + y.abs() + z.abs())))
    }

    /// Return the node with the numbers of its children shifted.
    pub(crate) fn moved(&self, shift: u32) -> Node {
        let child = self.child.map(|child| if child & LEAF == 0 { child + shift } else { child });
        Node { child, ..*self }
    }
}
