//! What an object is checked against: the objects placed before it, and the borders of the picture.

use rtcli_bodies::Body;

/// Three coordinates.
pub type Vector = [f64; 3];

/// The shape of an object, by the names and parameters of the tracer.
#[derive(Clone, Debug)]
pub struct Shape {
    /// The kind.
    pub kind: String,
    /// The center, or a point on the plane.
    pub position: Vector,
    /// The other numbers.
    pub parameters: Vec<f64>,
}

impl Shape {
    /// Returns the solid; None for a shape without an inside, such as a plane.
    pub fn body(&self) -> Option<Body> {
        Body::new(&self.kind, self.position, &self.parameters)
    }
}

/// What the picture shows.
#[derive(Clone, Debug)]
pub struct View {
    /// Width and height, in pixels.
    pub size: [f64; 2],
    /// In pixels; of an orthographic camera, pixels per unit of the world.
    pub focal_lengths: [f64; 2],
    /// In pixels from the left and the top edge.
    pub principal_point: [f64; 2],
    /// Whether the rays are parallel.
    pub is_orthographic: bool,
    /// The eye.
    pub position: Vector,
    /// The axis of the picture to the right.
    pub right: Vector,
    /// The axis of the picture upward.
    pub up: Vector,
    /// The direction of the view.
    pub forward: Vector,
}

impl View {
    /// Returns the planes that bound what the picture shows but for a margin, as outward normal n and limit d:
    /// n . (p - eye) <= d.
    ///
    /// A picture from x_0 to x_1 shows the points of camera space with x_0 z <= x <= x_1 z or, if the camera is
    /// orthographic, x_0 <= x <= x_1; and so for y.
    fn borders(&self, margin: f64) -> [(Vector, f64); 5] {
        let ([width, height], [focal_x, focal_y], [center_x, center_y]) =
            (self.size, self.focal_lengths, self.principal_point);
        let border = |axis: Vector, sign: f64, bound: f64| {
            let depth = if self.is_orthographic { 0.0 } else { -sign * bound };
            let normal = [0, 1, 2].map(|i| sign * axis[i] + depth * self.forward[i]);
            (normal, if self.is_orthographic { sign * bound } else { 0.0 })
        };
        [
            (negative(self.forward), 0.0),
            border(self.right, -1.0, (margin - center_x) / focal_x),
            border(self.right, 1.0, (width - margin - center_x) / focal_x),
            border(self.up, 1.0, (center_y - margin) / focal_y),
            border(self.up, -1.0, (center_y - height + margin) / focal_y),
        ]
    }
}

/// An object of a sample.
pub struct Placed<'a> {
    /// Its place among all objects, in the order of the file.
    pub number: usize,
    /// Its name.
    pub name: Option<String>,
    /// The number of its group.
    pub group: usize,
    /// The shape.
    pub shape: Shape,
    /// The solid, if it is one.
    pub body: Option<Body>,
    /// Its keys and their values in JSON.
    pub keys: Vec<(&'a str, String)>,
}

impl Placed<'_> {
    /// Returns how messages name it.
    pub fn label(&self) -> String {
        self.name.clone().unwrap_or_else(|| format!("objects[{}]", self.number))
    }
}

/// What an object is checked against.
pub struct Surroundings<'a> {
    /// The objects placed before it.
    pub others: &'a [Placed<'a>],
    /// The picture.
    pub view: &'a View,
}

/// A condition that the objects of a group must meet.
#[derive(Clone, Debug)]
pub struct Requirement {
    kind: &'static Kind,
    margin: f64,
}

impl Requirement {
    /// Returns a requirement of a kind with its margin; None if there is no such kind.
    pub fn new(kind: &str, margin: f64) -> Option<Requirement> {
        let kind = KINDS.iter().find(|known| known.name == kind)?;
        Some(Requirement { kind, margin })
    }

    /// Returns the name of the kind.
    pub fn kind(&self) -> &'static str {
        self.kind.name
    }

    /// Returns the objects that do not meet it; None if a candidate does.
    pub fn refused(&self, candidate: &Placed<'_>, around: &Surroundings<'_>) -> Option<String> {
        // Only solids can be too close, or reach out of the picture.
        let body = candidate.body.as_ref()?;
        (self.kind.refused)(self.margin, candidate, body, around)
    }
}

/// A kind of constraint on objects: its name in a template, and its check.
#[derive(Debug)]
struct Kind {
    name: &'static str,
    refused: fn(f64, &Placed<'_>, &Body, &Surroundings<'_>) -> Option<String>,
}

const KINDS: &[Kind] = &[
    Kind {
        name: "apart",
        refused: |margin, candidate, body, around| {
            let are_apart = |other: &Body| {
                let distance = body.distance(other);
                distance > 0.0 && distance >= margin
            };
            let near =
                around.others.iter().find(|other| other.body.as_ref().is_some_and(|body| !are_apart(body)))?;
            Some(format!("{} and {}", candidate.label(), near.label()))
        },
    },
    Kind {
        name: "in_view",
        // A convex object is on one side of a plane if its farthest point in the direction of the plane's normal is.
        refused: |margin, candidate, body, around| {
            let from_eye = difference(candidate.shape.position, around.view.position);
            let reaches_out =
                |&(outward, limit): &(Vector, f64)| dot(outward, from_eye) + body.reach(outward) > limit;
            around.view.borders(margin).iter().any(reaches_out).then(|| candidate.label())
        },
    },
];

/// The scalar product.
pub fn dot(a: Vector, b: Vector) -> f64 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

/// The vector from b to a.
pub fn difference(a: Vector, b: Vector) -> Vector {
    [a[0] - b[0], a[1] - b[1], a[2] - b[2]]
}

/// The opposite vector, with 0 for the opposite of 0.
pub fn negative(a: Vector) -> Vector {
    a.map(|component| 0.0 - component)
}

/// The unit vector, v / |v|, as `rtcli.scene.vectors` computes it.
pub fn unit(vector: Vector) -> Vector {
    // Scaled first, so that no square overflows or vanishes.
    let largest = vector.iter().fold(0.0, |largest: f64, component| largest.max(component.abs()));
    let scaled = vector.map(|component| component / largest);
    let length = dot(scaled, scaled).sqrt();
    scaled.map(|component| component / length)
}

#[cfg(test)]
mod tests {
    use super::{Placed, Requirement, Shape, Surroundings, View};

    fn sphere(name: &str, position: [f64; 3]) -> Placed<'static> {
        let shape = Shape { kind: "sphere".into(), position, parameters: vec![1.0] };
        Placed { number: 0, name: Some(name.into()), group: 0, body: shape.body(), shape, keys: Vec::new() }
    }

    /// A picture of 20 x 20 pixels, whose borders are at 45 degrees or, of parallel rays, at 10 from the middle.
    fn view(is_orthographic: bool) -> View {
        View {
            size: [20.0; 2],
            focal_lengths: [if is_orthographic { 1.0 } else { 10.0 }; 2],
            principal_point: [10.0; 2],
            is_orthographic,
            position: [0.0; 3],
            right: [1.0, 0.0, 0.0],
            up: [0.0, 1.0, 0.0],
            forward: [0.0, 0.0, -1.0],
        }
    }

    fn refused(kind: &str, margin: f64, position: [f64; 3], is_orthographic: bool) -> Option<String> {
        let others = [sphere("first", [0.0, 0.0, -10.0])];
        let around = Surroundings { others: &others, view: &view(is_orthographic) };
        Requirement::new(kind, margin).unwrap().refused(&sphere("second", position), &around)
    }

    #[test]
    fn objects_are_apart_if_their_surfaces_are() {
        assert_eq!(refused("apart", 0.5, [2.6, 0.0, -10.0], false), None);
        assert_eq!(refused("apart", 0.5, [0.0, 2.4, -10.0], false).unwrap(), "second and first");
        assert!(refused("apart", 0.0, [0.5, 0.0, -10.0], false).is_some());
    }

    #[test]
    fn an_object_is_in_view_if_all_of_it_is() {
        // The surface of a sphere around (x, 0, -10) touches the border at x + sqrt(2) = 10.
        for (x, is_seen) in [(8.58, true), (8.59, false), (-8.58, true), (-8.59, false)] {
            assert_eq!(refused("in_view", 0.0, [x, 0.0, -10.0], false).is_none(), is_seen);
            assert_eq!(refused("in_view", 0.0, [0.0, x, -10.0], false).is_none(), is_seen);
        }
        assert_eq!(refused("in_view", 0.0, [0.0, 0.0, -0.5], false).unwrap(), "second");
        assert!(refused("in_view", 9.0, [0.0, 0.0, -10.0], false).is_some());
    }

    #[test]
    fn parallel_rays_have_parallel_borders() {
        for (x, is_seen) in [(7.9, true), (8.1, false), (-8.1, false)] {
            assert_eq!(refused("in_view", 1.0, [x, 0.0, -3.0], true).is_none(), is_seen);
        }
    }
}
