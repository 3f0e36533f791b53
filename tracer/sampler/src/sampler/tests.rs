use crate::constraints::{Requirement, Shape, View};
use crate::value::{Context, Drawn, Value};

use super::{Caller, Group, Outcome, Rejections, Sampler, Try};
use crate::json::mapping;

const CONTEXT: Context<'_> = Context { index: 3, attempt: 0, element: 0, factors: &[] };
const VIEW: View = View {
    size: [100.0; 2],
    focal_lengths: [50.0; 2],
    principal_point: [50.0; 2],
    is_orthographic: false,
    position: [0.0; 3],
    right: [1.0, 0.0, 0.0],
    up: [0.0, 1.0, 0.0],
    forward: [0.0, 0.0, -1.0],
};

/// A caller that knows no more objects, gives them back as the reason, and waits.
struct Alone;

impl Caller for Alone {
    fn shape_of(&mut self, json: &str) -> Result<Shape, String> {
        Err(json.into())
    }

    fn is_cancelled(&mut self) -> bool {
        false
    }
}

fn constant(json: &str) -> Value {
    Value::Constant(json.into())
}

fn uniform(key: u64, low: f64, high: f64) -> Value {
    Value::Drawn(Drawn::new("uniform", [key, 0], vec![low, high], Vec::new()).unwrap())
}

fn keys(pairs: Vec<(&str, Value)>) -> Vec<(String, Value)> {
    pairs.into_iter().map(|(key, value)| (key.into(), value)).collect()
}

fn group(name: Option<&str>, repeat: Option<&str>, alternative: Vec<(&str, Value)>) -> Group {
    Group {
        name: name.map(Into::into),
        repeat: repeat.map(constant),
        rest_on: None,
        form: constant("0"),
        alternatives: vec![keys(alternative)],
        requirements: Vec::new(),
    }
}

fn floor() -> Group {
    let up = ("normal", constant("[0, 2, 0]"));
    group(
        Some("floor"),
        None,
        vec![
            ("type", constant("\"plane\"")),
            ("color", constant("\"red\"")),
            ("position", constant("[9, -1, 9]")),
            up,
        ],
    )
}

fn balls(repeat: &str, radius: Value, span: f64) -> Group {
    let position = Value::List(vec![uniform(1, -span, span), uniform(2, -span, span), constant("-9")]);
    group(
        Some("balls"),
        Some(repeat),
        vec![
            ("type", constant("\"sphere\"")),
            ("name", constant("\"balls\"")),
            ("position", position),
            ("radius", radius),
            ("color", constant("\"red\"")),
        ],
    )
}

/// A try and what it counts; the objects are in JSON, or there are none and perhaps an object that is not valid.
struct Tried {
    objects: Result<Vec<String>, Option<String>>,
    rejections: Rejections,
}

fn tried(sampler: &Sampler, attempt: u64, attempts: u64) -> Tried {
    let mut rejections = Rejections::default();
    let own = Try { attempts, view: &VIEW, caller: &mut Alone, rejections: &mut rejections };
    let objects = match sampler.place(&Context { attempt, ..CONTEXT }, own).unwrap() {
        Outcome::Placed(placed) => Ok(placed.iter().map(|object| mapping(&object.keys)).collect()),
        Outcome::Invalid(json) => Err(Some(json)),
        Outcome::Failed => Err(None),
    };
    Tried { objects, rejections }
}

fn sampler(groups: Vec<Group>) -> Sampler {
    let order = (0..groups.len()).collect();
    Sampler { sections: Vec::new(), groups, order }
}

#[test]
fn objects_are_named_by_number_and_stand_in_the_order_of_the_file() {
    let groups = vec![balls("2", constant("1"), 1.0), floor()];
    let Tried { objects, rejections } = tried(&Sampler { order: vec![1, 0], ..sampler(groups) }, 0, 1);
    let objects = objects.unwrap();
    let names: Vec<_> =
        objects.iter().map(|json| json.split("\"name\":\"").nth(1).unwrap().split('"').next()).collect();
    assert_eq!(names, [Some("balls[0]"), Some("balls[1]"), Some("floor")]);
    assert_eq!((rejections.draws, rejections.checks), (0, Vec::new()));
}

#[test]
fn an_object_rests_on_its_plane() {
    let ball = Group { rest_on: Some(0), ..balls("1", constant("0.25"), 1.0) };
    let objects = tried(&sampler(vec![floor(), ball]), 0, 1).objects.unwrap();
    assert!(objects[1].contains(",-0.75,-9.0]"), "{objects:?}");
}

#[test]
fn an_object_is_drawn_again_until_it_meets_its_constraints() {
    let apart = vec![Requirement::new("apart", 0.0).unwrap()];
    let crowd = Group { requirements: apart, ..balls("4", constant("1"), 2.5) };
    let Tried { objects, rejections } = tried(&sampler(vec![crowd]), 0, 1000);
    assert_eq!(objects.unwrap().len(), 4);
    let [refusal] = &rejections.refusals[..] else { panic!("nothing was refused") };
    assert_eq!((refusal.kind, refusal.ended), ("apart", 0));
    assert_eq!(
        (rejections.draws, &rejections.checks[..]),
        (4 + refusal.count, &[("apart", rejections.draws)][..])
    );
}

#[test]
fn an_object_that_never_fits_ends_the_sample() {
    let apart = vec![Requirement::new("apart", 0.0).unwrap()];
    let crowd = Group { requirements: apart, ..balls("2", constant("9"), 1.0) };
    let Tried { objects, rejections } = tried(&sampler(vec![crowd]), 0, 5);
    assert_eq!(objects, Err(None));
    let refusal = &rejections.refusals[0];
    assert_eq!((refusal.count, refusal.ended, refusal.last.as_str()), (5, 1, "balls[1] and balls[0]"));
}

#[test]
fn an_object_that_is_not_valid_ends_the_sample() {
    let objects = tried(&sampler(vec![balls("1", constant("-1"), 1.0)]), 0, 5).objects;
    assert!(objects.unwrap_err().unwrap().contains("\"radius\":-1"));
}

#[test]
fn attempts_and_elements_have_words_of_their_own() {
    let objects =
        |attempt, repeat| tried(&sampler(vec![balls(repeat, constant("1"), 1.0)]), attempt, 1).objects.unwrap();
    assert_ne!(objects(0, "1"), objects(1, "1"));
    assert_eq!(objects(0, "2")[0], objects(0, "1")[0]);
}
