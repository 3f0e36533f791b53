//! Questions about values that are not plainly valid, which only the models in Python can answer.

use rtcli_plain::PlainScene;
use rtcli_sampler::Shape;
use rtcli_tracer::world::Camera;

/// The models of scenes. Each question is about JSON; the error is the reason why it is not valid.
pub trait Models {
    /// A camera.
    fn camera_of(&mut self, camera: &str) -> Result<Camera, String>;

    /// The shape of an object.
    fn shape_of(&mut self, object: &str) -> Result<Shape, String>;

    /// A whole scene.
    fn scene_of(&mut self, scene: &str) -> Result<PlainScene, String>;

    /// Whether an answer failed, so that the work is to end.
    fn has_failed(&self) -> bool;
}
