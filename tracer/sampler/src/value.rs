//! Values with draws among their parts, and the kinds of draws.

use rtcli_draws::Draw;
use rtcli_reader::json::{write_number, write_numbers};

use crate::color::linear_from_hsv;
use crate::json::{write_list, write_text};

/// What draws depend on beside their keys.
#[derive(Clone, Copy, Debug)]
pub struct Context<'a> {
    /// The index of the sample.
    pub index: u64,
    /// How often the sample or object was drawn before.
    pub attempt: u64,
    /// The number of the object in its group, or 0.
    pub element: u64,
    /// The values that the draws `factor` number, in JSON.
    pub factors: &'a [String],
}

/// A value of a template.
#[derive(Debug)]
pub enum Value {
    /// A value without draws, in JSON.
    Constant(String),
    /// A list.
    List(Vec<Value>),
    /// A mapping.
    Mapping(Vec<(String, Value)>),
    /// A draw.
    Drawn(Drawn),
}

impl Value {
    /// Writes the value in a sample as JSON.
    pub fn write(&self, context: &Context<'_>, json: &mut String) -> Option<()> {
        match self {
            Value::Constant(text) => json.push_str(text),
            Value::List(items) => write_list(items, json, |item, json| item.write(context, json))?,
            Value::Mapping(entries) => {
                json.push('{');
                for (number, (key, value)) in entries.iter().enumerate() {
                    if number > 0 {
                        json.push(',');
                    }
                    write_text(key, json);
                    json.push(':');
                    value.write(context, json)?;
                }
                json.push('}');
            }
            Value::Drawn(drawn) => {
                let Context { index, attempt, element, .. } = *context;
                drawn.write(Draw::new(drawn.key, index, attempt, element), context, json)?;
            }
        }
        Some(())
    }

    /// Returns the value in a sample as JSON.
    pub fn json(&self, context: &Context<'_>) -> Option<String> {
        let mut json = String::new();
        self.write(context, &mut json)?;
        Some(json)
    }

    /// Returns a value that is a number.
    pub fn number<T: std::str::FromStr>(&self, context: &Context<'_>) -> Option<T> {
        self.json(context)?.parse().ok()
    }
}

/// A draw.
#[derive(Debug)]
pub struct Drawn {
    kind: &'static Kind,
    key: [u64; 2],
    numbers: Vec<f64>,
    parts: Vec<Value>,
}

impl Drawn {
    /// Returns a draw of a kind, with the key of its words, its parameters, and values within it; None if there is
    /// no such kind.
    pub fn new(kind: &str, key: [u64; 2], numbers: Vec<f64>, parts: Vec<Value>) -> Option<Drawn> {
        let kind = KINDS.iter().find(|known| known.name == kind)?;
        Some(Drawn { kind, key, numbers, parts })
    }

    /// Writes the value that a random word stands for as JSON.
    pub fn write(&self, word: Draw, context: &Context<'_>, json: &mut String) -> Option<()> {
        (self.kind.write)(self, word, context, json)
    }

    fn numbers<const N: usize>(&self) -> Option<[f64; N]> {
        self.numbers[..].try_into().ok()
    }

    fn number_of_part(&self, part: usize, context: &Context<'_>) -> Option<f64> {
        self.parts.get(part)?.number(context)
    }
}

/// A kind of draw: its name in a template, and how it writes the value of a random word.
#[derive(Debug)]
struct Kind {
    name: &'static str,
    write: fn(&Drawn, Draw, &Context<'_>, &mut String) -> Option<()>,
}

/// The kinds of draws; `rtcli.template.draws` says what each takes.
const KINDS: &[Kind] = &[
    Kind {
        name: "uniform",
        write: |drawn, word, _, json| {
            let [low, high] = drawn.numbers()?;
            write_number(word.uniform(low, high), json);
            Some(())
        },
    },
    Kind {
        name: "log_uniform",
        write: |drawn, word, _, json| {
            let [low, high] = drawn.numbers()?;
            write_number(word.log_uniform(low, high), json);
            Some(())
        },
    },
    Kind {
        name: "normal",
        write: |drawn, word, _, json| {
            let [mean, deviation, low, high] = drawn.numbers()?;
            write_number(word.normal(mean, deviation, low, high), json);
            Some(())
        },
    },
    Kind {
        name: "integers",
        write: |drawn, word, _, json| {
            let [first, count] = drawn.numbers()?;
            json.push_str(&(first as i64 + word.below(count as u64) as i64).to_string());
            Some(())
        },
    },
    Kind {
        name: "choice",
        write: |drawn, word, context, json| {
            let mut left = word.below(drawn.numbers.iter().sum::<f64>() as u64) as f64;
            let chosen = drawn.numbers.iter().position(|weight| {
                left -= weight;
                left < 0.0
            });
            drawn.parts.get(chosen?)?.write(context, json)
        },
    },
    Kind {
        name: "hsv",
        write: |drawn, _, context, json| {
            let part = |number| drawn.number_of_part(number, context);
            write_numbers(&linear_from_hsv(part(0)?, part(1)?, part(2)?), ",", json);
            Some(())
        },
    },
    Kind {
        name: "all",
        write: |drawn, _, context, json| {
            let [part] = &drawn.parts[..] else { return None };
            write_list(&[part; 3], json, |part, json| part.write(context, json))
        },
    },
    Kind {
        name: "factor",
        write: |drawn, _, context, json| {
            let [number] = drawn.numbers()?;
            json.push_str(context.factors.get(number as usize)?);
            Some(())
        },
    },
    Kind {
        name: "linspace",
        write: |drawn, word, _, json| {
            let [first, last, count] = drawn.numbers()?;
            let level = word.below(count as u64) as f64;
            let is_last = level > 0.0 && level == count - 1.0;
            let steps = (count - 1.0).max(1.0);
            write_number(if is_last { last } else { first + (last - first) * level / steps }, json);
            Some(())
        },
    },
    Kind {
        name: "range",
        write: |drawn, word, _, json| {
            let [first, end, step, count] = drawn.numbers()?;
            let level = first + word.below(count as u64) as f64 * step;
            write_number(if level < end { level } else { end }, json);
            Some(())
        },
    },
];

#[cfg(test)]
mod tests {
    use rtcli_draws::Draw;

    use super::{Context, Drawn, Value};

    const CONTEXT: Context<'_> = Context { index: 0, attempt: 0, element: 0, factors: &[] };

    fn constant(text: &str) -> Value {
        Value::Constant(text.into())
    }

    fn drawn(kind: &str, numbers: &[f64], parts: Vec<Value>) -> Drawn {
        Drawn::new(kind, [1, 2], numbers.to_vec(), parts).unwrap()
    }

    fn written(drawn: &Drawn, word: u64) -> Option<String> {
        let mut json = String::new();
        drawn.write(Draw(word), &CONTEXT, &mut json).map(|()| json)
    }

    #[test]
    fn a_word_decides_the_value() {
        let texts = |kind, numbers: &[f64], parts: fn() -> Vec<Value>| {
            let drawn = drawn(kind, numbers, parts());
            [0, 1 << 63, u64::MAX].map(|word| written(&drawn, word).unwrap())
        };
        let named = || vec![constant("\"a\""), constant("\"b\"")];
        assert_eq!(texts("integers", &[3.0, 4.0], Vec::new), ["3", "5", "6"]);
        assert_eq!(texts("choice", &[3.0, 1.0], named), ["\"a\"", "\"a\"", "\"b\""]);
        assert_eq!(texts("linspace", &[0.0, 1.0, 3.0], Vec::new), ["0.0", "0.5", "1.0"]);
        assert_eq!(texts("range", &[0.0, 0.3, 0.1, 4.0], Vec::new), ["0.0", "0.2", "0.3"]);
        assert_eq!(texts("all", &[], || vec![constant("2")]), ["[2,2,2]"; 3]);
    }

    #[test]
    fn parts_have_words_of_their_own() {
        let number = |key| Value::Drawn(Drawn::new("uniform", key, vec![0.0, 1.0], Vec::new()).unwrap());
        let list = Value::List(vec![number([1, 0]), number([2, 0]), number([1, 0])]);
        let text = list.json(&CONTEXT).unwrap();
        let parts: Vec<_> = text.trim_matches(['[', ']']).split(',').collect();
        assert_eq!(parts[0], parts[2]);
        assert_ne!(parts[0], parts[1]);
    }

    #[test]
    fn what_no_template_has_gives_nothing() {
        assert!(Drawn::new("dice", [0; 2], Vec::new(), Vec::new()).is_none());
        assert_eq!(written(&drawn("uniform", &[1.0], Vec::new()), 0), None);
        assert_eq!(written(&drawn("factor", &[0.0], Vec::new()), 0), None);
        assert_eq!(written(&drawn("choice", &[1.0], Vec::new()), 0), None);
    }
}
