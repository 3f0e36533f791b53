//! What a sample is, as a line of JSON: factors, camera, and for each object what it is, where it is, and its masks.

use std::collections::HashMap;
use std::fmt::Display;

use rtcli_plain::camera_matrices;
use rtcli_reader::json::{write_ascii, write_number, write_numbers};
use rtcli_reader::written::write_object;
use rtcli_sampler::{Placed, Sampler, negative};
use rtcli_tracer::rle::PixelBox;

use crate::picture::Picture;
use crate::template::Failure;

const AXES: [[f64; 3]; 3] = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];

/// What stands above the objects of a sample's labels.
#[derive(Clone, Copy, Debug)]
pub struct Header<'a> {
    /// The name and version of the software.
    pub software: &'a str,
    /// The index of the sample.
    pub index: u64,
    /// The name of its split.
    pub split: &'a str,
    /// The attempt of its draws, beside those of objects.
    pub attempt: u64,
    /// The factors in JSON.
    pub factors: &'a str,
}

/// Returns the labels of a sample as `json.dumps` writes them without spaces; objects have some only if that is wanted,
/// since they need ids.
pub fn labels(
    header: Header<'_>,
    sampler: &Sampler,
    placed: Option<&[Placed<'_>]>,
    picture: &mut Picture<'_>,
) -> Result<String, Failure> {
    let Header { software, index, split, attempt, factors } = header;
    let mut json = String::from("{\"software\":");
    write_ascii(software, &mut json);
    json.push_str(&format!(",\"index\":{index},\"split\":"));
    write_ascii(split, &mut json);
    let camera = camera_matrices(&picture.scene.world.camera, picture.scene.window());
    json.push_str(&format!(",\"attempt\":{attempt},\"factors\":{factors},\"camera\":{camera},\"exposure\":"));
    write_number(picture.exposure()?, &mut json);
    json.push_str(",\"objects\":[");
    if let Some(placed) = placed {
        write_objects(sampler, placed, picture, &mut json)?;
    }
    json.push_str("]}");
    Ok(json)
}

fn write_objects(
    sampler: &Sampler,
    placed: &[Placed<'_>],
    picture: &mut Picture<'_>,
    json: &mut String,
) -> Result<(), Failure> {
    let fractions = picture.fractions()?.to_vec();
    let hidden: Vec<u32> =
        (0_u32..).zip(&fractions).filter(|(_, share)| **share != Some(1.0)).map(|(i, _)| i).collect();
    let amodal: HashMap<_, _> = hidden.iter().zip(picture.amodal_masks(&hidden)?).collect();
    let (width, height) = picture.size();
    let mask_of = |counts: &str, json: &mut String| {
        json.push_str(&format!("{{\"size\":[{height},{width}],\"counts\":"));
        write_ascii(counts, json);
        json.push('}');
    };
    let (colors, masks) = (picture.scene.objects.color.as_chunks::<3>().0, picture.masks());
    let names = picture.scene.names();
    for (number, object) in placed.iter().enumerate() {
        let (pixels, boxed) = picture.boxes()[number];
        let (own_mask, own_box) = (&masks[number], boxed);
        let (amodal_mask, amodal_box) =
            amodal.get(&(number as u32)).map_or((own_mask, own_box), |(mask, boxed)| (mask, *boxed));
        json.push_str(if number == 0 { "{\"id\":" } else { ",{\"id\":" });
        json.push_str(&format!("{},\"name\":", number + 1));
        write_or_null(names[number], json, write_ascii);
        json.push_str(",\"group\":");
        write_or_null(sampler.groups[object.group].name.as_deref(), json, write_ascii);
        json.push(',');
        write_object(&object.shape.kind, &object.keys, &colors[number], json).ok_or(Failure::Unknown)?;
        json.push_str(",\"extent\":");
        let extent =
            object.body.as_ref().map(|body| AXES.map(|axis| body.reach(axis) + body.reach(negative(axis))));
        write_or_null(extent, json, |extent, json| write_numbers(&extent, ",", json));
        json.push_str(&format!(",\"visible_pixels\":{pixels},\"visible_fraction\":"));
        write_or_null(fractions[number], json, write_number);
        json.push_str(",\"bbox\":");
        write_box(own_box, json);
        json.push_str(",\"mask\":");
        mask_of(own_mask, json);
        json.push_str(",\"amodal_bbox\":");
        write_box(amodal_box, json);
        json.push_str(",\"amodal_mask\":");
        write_or_null(amodal_box.map(|_| amodal_mask), json, |counts, json| mask_of(counts, json));
        json.push('}');
    }
    Ok(())
}

fn write_or_null<T>(value: Option<T>, json: &mut String, write: impl FnOnce(T, &mut String)) {
    match value {
        Some(value) => write(value, json),
        None => json.push_str("null"),
    }
}

fn write_box(boxed: PixelBox, json: &mut String) {
    write_or_null(boxed, json, |sides, json| json.push_str(&list(&sides)));
}

/// Returns whole numbers as a list.
pub fn list(numbers: &[impl Display]) -> String {
    let numbers: Vec<_> = numbers.iter().map(|number| format!("{number}")).collect();
    format!("[{}]", numbers.join(","))
}
