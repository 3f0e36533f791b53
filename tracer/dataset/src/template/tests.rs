use std::sync::Arc;

use rtcli_plain::PlainScene;
use rtcli_reader::{Format, read};
use rtcli_sampler::{Drawn, Group, Shape, Value};
use rtcli_tracer::develop::{BitDepth, Developer, ToneCurve};
use rtcli_tracer::world::Camera;
use rtcli_tracer::{Level, Monitor, Pass, Stopped};

use super::{Failure, Made, Request, Sample, Template, plain_camera};
use crate::constraints::Requirement;
use crate::files::Outputs;
use crate::models::Models;
use crate::picture::Engine;

const CAMERA: &str = r#"{"resolution":[12,8],"fov":60}"#;
const ALL: Outputs = Outputs { files: true, tar: true, parts: true, arrays: true, levels: true };

/// Models that know one camera and one scene, and no object.
#[derive(Default)]
struct Known {
    asked: Vec<String>,
    fails: bool,
}

impl Models for Known {
    fn camera_of(&mut self, camera: &str) -> Result<Camera, String> {
        self.asked.push(camera.into());
        plain_camera(CAMERA).ok_or_else(String::new)
    }

    fn shape_of(&mut self, object: &str) -> Result<Shape, String> {
        self.asked.push(object.into());
        Err("no object".into())
    }

    fn scene_of(&mut self, scene: &str) -> Result<PlainScene, String> {
        self.asked.push(scene.into());
        let known = format!("{{\"camera\":{CAMERA}}}");
        read(known.as_bytes(), Format::Json, &[]).and_then(PlainScene::new).ok_or_else(String::new)
    }

    fn has_failed(&self) -> bool {
        self.fails && !self.asked.is_empty()
    }
}

fn developer(exposure: f64, tone: ToneCurve, bits: BitDepth) -> Arc<Developer> {
    Arc::new(Developer::new(exposure, tone, bits))
}

fn constant(json: &str) -> Value {
    Value::Constant(json.into())
}

/// A ball on the right or the left at random, smaller than a wall in front of it or not.
fn template(camera: &str, radius: &str, requirements: &[(&str, f64)]) -> Template {
    let side = Drawn::new("uniform", [7, 7], vec![-2.0, 2.0], Vec::new()).unwrap();
    let keys = |keys: Vec<(&str, Value)>| keys.into_iter().map(|(key, value)| (key.into(), value)).collect();
    let group = |name: &str, alternative| Group {
        name: Some(name.into()),
        repeat: None,
        rest_on: None,
        form: constant("0"),
        alternatives: vec![alternative],
        requirements: Vec::new(),
    };
    let wall = keys(vec![
        ("type", constant("\"box\"")),
        ("position", constant("[1,0,-3]")),
        ("size", constant("[2,9,0.1]")),
        ("color", constant("\"red\"")),
    ]);
    let ball = keys(vec![
        ("type", constant("\"sphere\"")),
        ("radius", constant(radius)),
        ("position", Value::List(vec![Value::Drawn(side), constant("0"), constant("-5")])),
        ("color", constant("[0.5,0.25,1]")),
    ]);
    let sampler = rtcli_sampler::Sampler {
        sections: vec![("camera".into(), constant(camera)), ("lights".into(), constant("[]"))],
        groups: vec![group("wall", wall), group("ball", ball)],
        order: vec![0, 1],
    };
    let requirements =
        requirements.iter().map(|(kind, least)| Requirement::new(kind, *least, 1).unwrap()).collect();
    Template { sampler, requirements, tries: 50 }
}

fn make(template: &Template, request: &Request<'_>, models: &mut Known) -> Result<Made, Failure> {
    let monitor = Monitor::default();
    template.make(request, engine(&monitor), models)
}

fn engine(monitor: &Monitor) -> Engine<'_> {
    Engine { level: Level::best(), developers: developer, monitor, software: "rtcli test" }
}

fn request(outputs: Outputs, passes: &[Pass]) -> Request<'_> {
    Request {
        index: 7,
        factors: &[],
        tries: u64::MAX,
        passes,
        outputs,
        labels: Some(("train", "{\"a\":1}", true)),
    }
}

fn made(template: &Template, outputs: Outputs, passes: &[Pass]) -> Sample {
    make(template, &request(outputs, passes), &mut Known::default()).unwrap().sample.unwrap()
}

#[test]
fn a_sample_is_drawn_again_until_its_picture_meets_all_constraints() {
    let hidden = |fraction| {
        let template = template(CAMERA, "0.5", &[("min_visible_pixels", 1.0), ("min_visible_fraction", fraction)]);
        make(&template, &request(Outputs::default(), &[]), &mut Known::default()).unwrap()
    };
    let tries: Vec<_> = [0.1, 1.0]
        .map(hidden)
        .into_iter()
        .map(|made| {
            let count: usize = made.rejections.refusals.iter().map(|refusal| refusal.count).sum();
            assert_eq!(made.rejections.draws, count + 1);
            assert_eq!(made.sample.unwrap().attempt, 50 * count as u64);
            count
        })
        .collect();
    assert!(tries[0] <= tries[1], "{tries:?}");
}

#[test]
fn a_picture_that_never_meets_a_constraint_makes_no_sample() {
    let template = template(CAMERA, "0.5", &[("min_visible_pixels", 1e6)]);
    let few = Request { tries: 3, ..request(ALL, &[]) };
    let Made { sample, rejections } = make(&template, &few, &mut Known::default()).unwrap();
    assert!(sample.is_none());
    let [refusal] = &rejections.refusals[..] else { panic!("one constraint refuses") };
    assert_eq!((refusal.kind, refusal.count, refusal.ended), ("min_visible_pixels", 3, 3));
    assert_eq!(refusal.last, "ball");
    assert_eq!(rejections.checks, [("scene", 3), ("min_visible_pixels", 3)]);
}

#[test]
fn a_sample_that_ids_refuse_costs_no_light() {
    let template = template(CAMERA, "0.5", &[("min_visible_pixels", 1e6)]);
    let (monitor, few) = (Monitor::default(), Request { tries: 3, ..request(ALL, &[Pass::Depth]) });
    let made = template.make(&few, engine(&monitor), &mut Known::default()).unwrap();
    assert!(made.sample.is_none());
    // The passes of each try, and nothing beside them.
    assert_eq!(monitor.done(), 3 * 12 * 8);
}

#[test]
fn labels_are_one_line_and_tell_of_all_objects() {
    let labels = made(&template(CAMERA, "0.5", &[]), Outputs::default(), &[]).labels.unwrap();
    let start = r#"{"software":"rtcli test","index":7,"split":"train","attempt":0,"factors":{"a":1},"camera":{"#;
    assert!(labels.starts_with(start), "{labels}");
    for part in [
        r#""exposure":0.0,"objects":[{"id":1,"name":"wall","group":"wall","type":"box","position":[1.0,0.0,-3.0]"#,
        r#""size":[2.0,9.0,0.1],"color":[1.0,0.0,0.0],"extent":[2.0,9.0,0.1],"visible_pixels":"#,
        r#"{"id":2,"name":"ball","group":"ball","type":"sphere","#,
        r#""mask":{"size":[8,12],"counts":""#,
    ] {
        assert!(labels.contains(part), "{labels}");
    }
    assert!(!labels.contains('\n') && labels.ends_with("]}"));
}

#[test]
fn what_is_wanted_does_not_depend_on_what_else_is() {
    let template = template(CAMERA, "0.5", &[]);
    let passes = [Pass::Depth, Pass::ObjectId];
    let all = made(&template, ALL, &passes);
    let only = |outputs| {
        let Sample { files, tar, parts, arrays, levels, labels, .. } = made(&template, outputs, &passes);
        assert_eq!(labels, all.labels);
        (files, tar, parts, arrays, levels)
    };
    let none = Outputs::default();
    assert_eq!(only(Outputs { files: true, ..none }), (all.files.clone(), vec![], vec![], vec![], None));
    assert_eq!(only(Outputs { tar: true, ..none }), (vec![], all.tar.clone(), vec![], vec![], None));
    assert_eq!(only(Outputs { parts: true, ..none }), (vec![], vec![], all.parts.clone(), vec![], None));
    assert_eq!(only(Outputs { arrays: true, ..none }), (vec![], vec![], vec![], all.arrays.clone(), None));
    assert_eq!(only(Outputs { levels: true, ..none }), (vec![], vec![], vec![], vec![], all.levels.clone()));
    let names: Vec<_> = all.files.iter().map(|(end, _)| end.as_str()).collect();
    assert_eq!(names, [".png", ".depth.png", ".object_id.png", ".json"]);
    assert_eq!(
        all.arrays.iter().map(|array| &array.1[..]).collect::<Vec<_>>(),
        [&[8, 12, 3][..], &[8, 12], &[8, 12]]
    );
    assert_eq!(all.parts[0].2, all.files[0].1);
}

#[test]
fn nothing_is_traced_if_only_the_scene_is_wanted() {
    let scene_only = Request { labels: None, ..request(Outputs::default(), &[Pass::Depth]) };
    let template = template(CAMERA, "0.5", &[]);
    let sample = make(&template, &scene_only, &mut Known::default()).unwrap().sample.unwrap();
    assert_eq!((sample.labels, sample.groups), (None, vec![0, 1]));
    assert!(
        sample.text.starts_with(&format!("{{\"camera\":{CAMERA},\"lights\":[],\"objects\":[{{\"type\":\"box\""))
    );
}

#[test]
fn models_answer_for_what_is_not_plainly_valid() {
    let mut models = Known::default();
    let scene_only = Request { labels: None, ..request(Outputs::default(), &[]) };
    make(&template("{\"a\":1}", "0.5", &[]), &scene_only, &mut models).unwrap().sample.unwrap();
    assert_eq!((models.asked.len(), &models.asked[0][..]), (2, "{\"a\":1}"));

    let Made { sample, rejections } =
        make(&template(CAMERA, "-1", &[]), &scene_only, &mut Known::default()).unwrap();
    assert!(sample.is_none());
    let [refusal] = &rejections.refusals[..] else { panic!("one constraint refuses") };
    assert_eq!((refusal.kind, refusal.count, &refusal.last[..]), ("scene", 50, "no object"));
}

#[test]
fn an_answer_that_fails_ends_the_work() {
    let mut failing = Known { fails: true, ..Known::default() };
    let failed = make(&template(CAMERA, "-1", &[]), &request(ALL, &[]), &mut failing);
    assert!(matches!(failed, Err(Failure::Stopped(Stopped::Cancelled))));
    assert_eq!(failing.asked.len(), 1);
}
