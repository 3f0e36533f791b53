use crate::constraints::{Requirement, Shape, View};
use crate::value::{Context, Drawn, Value};

use super::{Caller, Group, Placement, Sampler};

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

/// A caller that knows no more objects, and waits.
struct Alone;

impl Caller for Alone {
    fn shape_of(&mut self, _: &str) -> Option<Shape> {
        None
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

fn placed(groups: Vec<Group>, tries: u64) -> Placement {
    let order = (0..groups.len()).collect();
    let sampler = Sampler { sections: Vec::new(), groups, order };
    sampler.place(&CONTEXT, tries, &VIEW, &mut Alone).unwrap()
}

#[test]
fn objects_are_named_by_number_and_stand_in_the_order_of_the_file() {
    let groups = vec![balls("2", constant("1"), 1.0), floor()];
    let sampler = Sampler { sections: Vec::new(), groups, order: vec![1, 0] };
    let placement = sampler.place(&CONTEXT, 1, &VIEW, &mut Alone).unwrap();
    let objects = placement.objects.unwrap();
    let names: Vec<_> = objects.split("\"name\":").skip(1).map(|rest| rest.split('"').nth(1).unwrap()).collect();
    assert_eq!(names, ["balls[0]", "balls[1]", "floor"]);
    assert_eq!((placement.counts, placement.draws, placement.checks), (vec![2, 1], 0, Vec::new()));
}

#[test]
fn an_object_rests_on_its_plane() {
    let ball = Group { rest_on: Some(0), ..balls("1", constant("0.25"), 1.0) };
    let objects = placed(vec![floor(), ball], 1).objects.unwrap();
    assert!(objects.contains(",-0.75,-9.0]"), "{objects}");
}

#[test]
fn an_object_is_drawn_again_until_it_meets_its_constraints() {
    let apart = vec![Requirement::new("apart", 0.0).unwrap()];
    let crowd = Group { requirements: apart, ..balls("4", constant("1"), 2.5) };
    let placement = placed(vec![crowd], 1000);
    assert!(placement.objects.is_some());
    let [refusal] = &placement.refusals[..] else { panic!("nothing was refused") };
    assert_eq!((refusal.kind, refusal.ended), ("apart", 0));
    assert_eq!((placement.draws, &placement.checks[..]), (4 + refusal.count, &[("apart", placement.draws)][..]));
}

#[test]
fn an_object_that_never_fits_ends_the_sample() {
    let apart = vec![Requirement::new("apart", 0.0).unwrap()];
    let crowd = Group { requirements: apart, ..balls("2", constant("9"), 1.0) };
    let placement = placed(vec![crowd], 5);
    assert_eq!(placement.objects, None);
    let refusal = &placement.refusals[0];
    assert_eq!((refusal.count, refusal.ended, refusal.last.as_str()), (5, 1, "balls[1] and balls[0]"));
}

#[test]
fn an_object_that_is_not_valid_ends_the_sample() {
    let placement = placed(vec![balls("1", constant("-1"), 1.0)], 5);
    assert_eq!(placement.objects, None);
    assert!(placement.invalid.unwrap().contains("\"radius\":-1"));
}

#[test]
fn attempts_and_elements_have_words_of_their_own() {
    let texts = |attempt, repeat| {
        let sampler =
            Sampler { sections: Vec::new(), groups: vec![balls(repeat, constant("1"), 1.0)], order: vec![0] };
        sampler.place(&Context { attempt, ..CONTEXT }, 1, &VIEW, &mut Alone).unwrap().objects.unwrap()
    };
    assert_ne!(texts(0, "1"), texts(1, "1"));
    assert!(texts(0, "2").starts_with(texts(0, "1").trim_end_matches(']')));
}
