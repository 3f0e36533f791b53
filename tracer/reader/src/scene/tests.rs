use super::{Edit, Format, Scene, Setting, Step, read, read_object};

const CAMERA: &str = "camera: {resolution: [4, 3], fov: 40}\n";

fn yaml(text: &str) -> Option<Scene> {
    read(text.as_bytes(), Format::Yaml, &[])
}

fn camera_and(text: &str) -> Option<Scene> {
    yaml(&format!("{CAMERA}{text}"))
}

fn setting(scene: &Scene, section: &str, key: &str) -> Setting {
    let (_, settings) = scene.sections.iter().find(|(name, _)| *name == section).unwrap();
    settings.iter().find(|(name, _)| *name == key).unwrap().1.clone()
}

#[test]
fn block_flow_and_json_are_the_same_scene() {
    let block = "camera:\n  fov: 40  # degrees\n  resolution:\n  - 4\n  - 3\nobjects:\n- color: red\n  position: [0, 1, 2]\n  \
                 radius: 1.5\n  type: sphere\n  light:\n    intensity: 7\n";
    let flow = "{camera: {resolution: [4, 3], fov: 40}, objects: [{type: sphere, radius: 1.5,\n color: 'Red', # c\n \
                position: [0, 1, 2], light: {intensity: 7}}]}";
    let json = r##"{"camera": {"resolution": [4, 3], "fov": 40}, "objects": [{"type": "sphere", "radius": 1.5,
                "color": "#ff0000", "position": [0, 1, 2], "light": {"intensity": 7}}]}"##;
    let scene = yaml(block).unwrap();
    assert_eq!(scene.objects.position, [0.0, 1.0, 2.0]);
    assert_eq!(scene.objects.parameters, [1.5]);
    assert_eq!(scene.objects.color, [1.0, 0.0, 0.0]);
    assert_eq!(
        (scene.lights.parameters.as_slice(), scene.lights.carrier.as_slice()),
        (&[0.0, 1.0, 2.0, 0.0][..], &[0][..])
    );
    assert_eq!(yaml(flow), Some(scene.clone()));
    assert_eq!(read(json.as_bytes(), Format::Json, &[]), Some(scene));
}

#[test]
fn what_is_left_out_has_its_default() {
    let scene = yaml(CAMERA).unwrap();
    assert_eq!(setting(&scene, "camera", "up"), Setting::Numbers(vec![0.0, 1.0, 0.0]));
    assert_eq!(setting(&scene, "camera", "look_at"), Setting::Missing);
    assert_eq!(setting(&scene, "render", "samples"), Setting::Integer(1));
    assert_eq!(setting(&scene, "image", "tone"), Setting::Word("clip"));
}

#[test]
fn an_alias_stands_for_the_value_of_its_anchor() {
    let ball = "{type: sphere, position: &p [1, 2, 3], radius: &r 2, color: &c red}";
    let scene = camera_and(&format!(
        "objects:\n  - {ball}\n  - type: sphere\n    position: *p\n    radius: *r  # c\n    color: *c\n"
    ));
    assert_eq!(scene.unwrap().objects.position, [1.0, 2.0, 3.0, 1.0, 2.0, 3.0]);
}

#[test]
fn doubtful_anchors_and_aliases_are_not_read() {
    for values in
        ["&a *a", "&a [*a, 1, 2]", "*a", "&a &b [0, 0, 0]", "&a\n  - 0", "&a [0, 0, 0] x", "[&a 0, &a 1, *a]"]
    {
        assert_eq!(camera_and(&format!("lights:\n- intensity: 1\n  position: {values}\n")), None, "{values}");
    }
}

#[test]
fn values_that_aliases_add_are_limited() {
    let alias = "\n- {position: *p, intensity: 1}";
    let lights = |count| format!("lights:\n- {{position: &p [0, 0, 0], intensity: 1}}{}", alias.repeat(count));
    assert!(camera_and(&lights(1_000)).is_some());
    assert_eq!(camera_and(&lights(1_000_000)), None);
}

#[test]
fn names_are_unique_and_keep_their_lengths() {
    let plane = |name: &str| {
        format!("- {{type: plane, name: {name}, position: [0, 0, 0], normal: [0, 1, 0], color: red}}\n")
    };
    let named = |names: &[&str]| {
        camera_and(&format!("objects:\n{}", names.iter().map(|name| plane(name)).collect::<String>()))
    };
    assert_eq!(named(&["a b", "'é: 1'"]).unwrap().objects.names, "3:a b4:é: 1".as_bytes()[..].to_vec());
    assert_eq!(named(&["a", "\"a\""]), None);
    for name in ["null", "True", "1", "~", "''", "a: b", "[a]", "-", "\"\\n\"", "'a''b'", "!a"] {
        assert_eq!(named(&[name]), None, "{name}");
    }
}

#[test]
fn an_edit_replaces_or_adds_a_key() {
    let edits = [
        section_edit("camera", "fov", "30"),
        section_edit("image", "exposure", "auto"),
        section_edit("camera", "resolution", "[8, 6]"),
    ];
    let scene = read(b"camera: {fov: 40}", Format::Yaml, &edits).unwrap();
    assert_eq!(setting(&scene, "camera", "fov"), Setting::Number(30.0));
    assert_eq!(setting(&scene, "image", "exposure"), Setting::Word("auto"));
    for (section, key, value) in
        [("camera", "fov", "180"), ("camera", "x", "1"), ("objects", "fov", "1"), ("camera", "fov", "1\n")]
    {
        let edit = section_edit(section, key, value);
        assert_eq!(read(CAMERA.as_bytes(), Format::Yaml, &[edit]), None, "{section}.{key}={value}");
    }
}

#[test]
fn an_edit_changes_an_item_of_a_list_by_index_or_name() {
    let file = "\
objects:
- {type: plane, name: floor, position: [0, 0, 0], normal: [0, 1, 0], color: red}
- {type: sphere, name: ball, position: [0, 1, 0], radius: 1, color: red}
lights:
- {position: [0, 5, 0], intensity: 1}
";
    let changed = |path: &[Step], value| {
        let edit = Edit { path: path.to_vec(), value };
        read(format!("{CAMERA}{file}").as_bytes(), Format::Yaml, &[edit])
    };
    let (objects, lights, ball) = (Step::Key("objects"), Step::Key("lights"), Step::Key("ball"));
    let (position, light) = (Step::Key("position"), Step::Key("light"));
    let changes = [
        (&[objects, Step::Index(1), Step::Key("radius")][..], "2", "radius: 1", "radius: 2"),
        (&[objects, ball, position], "[1, 2, 3]", "[0, 1, 0], radius", "[1, 2, 3], radius"),
        (&[objects, ball, position, Step::Index(2)], "7", "[0, 1, 0], radius", "[0, 1, 7], radius"),
        (&[objects, ball, light, Step::Key("intensity")], "9", "radius: 1", "radius: 1, light: {intensity: 9}"),
        (&[lights, Step::Index(0), Step::Key("intensity")], "3", "intensity: 1", "intensity: 3"),
    ];
    for (path, value, before, after) in changes {
        let expected = camera_and(&file.replace(before, after));
        assert!(expected.is_some() && expected != camera_and(file), "{after}");
        assert_eq!(changed(path, value), expected, "{path:?}");
    }
    let refused = [
        (&[objects, Step::Index(2), Step::Key("radius")][..], "2"), // there is no such object
        (&[objects, Step::Key("bal"), Step::Key("radius")], "2"),
        (&[lights, ball, Step::Key("intensity")], "2"),
        (&[objects, ball, Step::Key("radius")], "0"),
        (&[objects, ball, Step::Key("normal")], "[0, 1, 0]"), // not of a sphere
        (&[objects, ball, Step::Key("name")], "x"),
        (&[objects, ball, position, Step::Index(3)], "7"),
        (&[objects, ball, light, Step::Key("radius")], "1"), // a light without intensity
        (&[objects, Step::Key("floor"), Step::Key("normal"), Step::Index(1)], "0"), // no direction
        (&[objects, ball, Step::Key("color"), Step::Index(0)], "1"), // of a color that is a word
        (&[objects, Step::Key("floor"), light, Step::Key("intensity")], "1"), // which no plane carries
        (&[objects, ball], "{}"),
        (&[objects], "[]"),
        (&[Step::Index(0)], "1"),
    ];
    for (path, value) in refused {
        assert_eq!(changed(path, value), None, "{path:?}");
    }
    let dotted = file.replace("floor", "ball.radius");
    let edit = Edit { path: vec![objects, ball, Step::Key("radius")], value: "2" };
    assert_eq!(read(format!("{CAMERA}{dotted}").as_bytes(), Format::Yaml, &[edit]), None);
}

fn section_edit<'a>(section: &'a str, key: &'a str, value: &'a str) -> Edit<'a> {
    Edit { path: vec![Step::Key(section), Step::Key(key)], value }
}

proptest::proptest! {
    #[test]
    fn no_text_makes_it_panic(text in "([-:,{}\\[\\]#&*'\"\\\\ \n\r0-9.e+]|camera|fov|position|objects|type|sphere|\u{e9}){0,60}") {
        for format in [Format::Json, Format::Yaml] {
            read(text.as_bytes(), format, &[]);
            read(format!("{CAMERA}{text}").as_bytes(), format, &[section_edit("camera", "position", &text)]);
        }
    }
}

#[test]
fn an_object_alone_is_read_as_in_a_scene() {
    let ball = r#"{"type": "sphere", "position": [1, 2, 3], "radius": 2, "color": "red", "name": "ball"}"#;
    let json = format!(r#"{{"camera": {{"resolution": [4, 3], "fov": 40}}, "objects": [{ball}]}}"#);
    assert_eq!(read_object(ball), read(json.as_bytes(), Format::Json, &[]).map(|scene| scene.objects));
    for wrong in
        [ball.replace("2, 3", "2"), ball.replace(": 2,", ": 0,"), format!("{ball} 1"), format!("[{ball}]")]
    {
        assert_eq!(read_object(&wrong), None);
    }
}
