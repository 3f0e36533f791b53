use rtcli_reader::{Format, read};

use super::PlainScene;

fn scene(text: &str) -> Option<PlainScene> {
    PlainScene::new(read(text.as_bytes(), Format::Yaml, &[]).expect("the reader takes it"))
}

#[test]
fn a_camera_has_one_lens_that_fits_its_projection() {
    let camera = |keys| scene(&format!("camera: {{resolution: [4, 2], {keys}}}")).map(|scene| scene.world.camera);
    assert_eq!(camera("fov: 90").unwrap().half_height, rtcli_tracer::half_tangent(90.0));
    assert_eq!(camera("fov_x: 90").unwrap().half_height, rtcli_tracer::half_tangent(90.0) / 2.0);
    assert_eq!(camera("height: 3, projection: orthographic").unwrap().half_height, 1.5);
    for keys in ["position: [0, 0, 0]", "fov: 90, fov_x: 90", "height: 3", "fov: 90, projection: orthographic"] {
        assert_eq!(camera(keys), None, "{keys}");
    }
}

#[test]
fn a_camera_looks_somewhere_and_not_along_its_up() {
    for keys in ["position: [1, 2, 3], look_at: [1, 2, 3]", "look_at: [0, 5, 0]", "up: [0, 0, 1]"] {
        assert!(scene(&format!("camera: {{resolution: [4, 2], fov: 90, {keys}}}")).is_none(), "{keys}");
    }
    let far = "camera: {resolution: [4, 2], fov: 90, position: [-1e308, 0, 0], look_at: [1e308, 0, 0]}";
    assert_eq!(scene(far).unwrap().world.camera.forward, [1.0, 0.0, 0.0]);
}

#[test]
fn a_picture_with_alpha_has_a_black_background() {
    let with = |keys| {
        scene(&format!("camera: {{resolution: [4, 2], fov: 90}}\nrender: {{background: red}}\n{keys}")).unwrap()
    };
    assert_eq!(with("").world.settings.background, [1.0, 0.0, 0.0]);
    let transparent = with("image: {alpha: true}");
    assert_eq!((transparent.world.settings.background, transparent.alpha), ([0.0; 3], true));
}

#[test]
fn objects_and_lights_become_those_of_the_world() {
    let text = "
camera: {resolution: [4, 2], fov: 90}
lights: [{type: sun, direction: [0, -1, 0], irradiance: 2}]
objects:
  - {type: plane, position: [0, -1, 0], normal: [0, 1, 0], color: [0, 0, 1], checker: {size: 2, color: [1, 0, 0]}}
  - {type: sphere, position: [1, 2, 3], radius: 0.5, color: [1, 1, 1], light: {intensity: 10}}
render: {max_depth: 0}
";
    let world = scene(text).unwrap().world;
    assert_eq!(world.objects.len(), 2);
    assert_eq!((world.objects[1].position, world.objects[1].color), ([1.0, 2.0, 3.0], [1.0; 3]));
    assert_eq!((world.checkers[0].object, world.checkers[0].size), (0, 2.0));
    assert_eq!(world.lights.iter().map(|light| light.carrier).collect::<Vec<_>>(), [None, Some(1)]);
    assert!(!world.settings.direct_light);
}

#[test]
fn objects_have_their_names() {
    let ball = |name| format!("  - {{type: sphere, position: [1, 2, 3], radius: 1, color: red{name}}}\n");
    let names = [", name: \"1:-🙂ö\"", "", ", name: \"-2:b\"", ", name: c"];
    let text = format!("camera: {{resolution: [4, 2], fov: 90}}\nobjects:\n{}", names.map(ball).concat());
    assert_eq!(scene(&text).unwrap().names(), [Some("1:-🙂ö"), None, Some("-2:b"), Some("c")]);
}
