//! How to get the values of a pass from the levels of its picture, in the metadata of files.

use rtcli_reader::json::{write_number, write_numbers};
use rtcli_tracer::pass_picture::Decode;

/// Returns how to get values from the levels of a pass, in JSON.
pub fn decode_json(decode: &Decode) -> String {
    let mut json = format!("{{\"value\":\"{}\"", decode.formula());
    match decode {
        Decode::Length { scale, clipped } => {
            json.push_str(",\"scale\":");
            write_number(*scale, &mut json);
            json.push_str(&format!(",\"nothing\":0,\"clipped_pixels\":{clipped}"));
        }
        Decode::Position { low, scale, clipped } => {
            json.push_str(",\"low\":");
            write_numbers(low, ",", &mut json);
            json.push_str(",\"scale\":");
            write_numbers(scale, ",", &mut json);
            json.push_str(&format!(",\"nothing\":[0,0,0],\"clipped_pixels\":{clipped}"));
        }
        Decode::Direction => json.push_str(",\"nothing\":[128,128,128]"),
        Decode::Share => (),
    }
    json.push('}');
    json
}

#[cfg(test)]
mod tests {
    use rtcli_tracer::pass_picture::Decode;

    use super::decode_json;

    #[test]
    fn formulas_stand_before_their_numbers() {
        let length = Decode::Length { scale: 1e-7, clipped: 2 };
        let expected = r#"{"value":"scale * level","scale":1e-07,"nothing":0,"clipped_pixels":2}"#;
        assert_eq!(decode_json(&length), expected);
        assert_eq!(decode_json(&Decode::Share), r#"{"value":"level / 65535"}"#);
    }
}
