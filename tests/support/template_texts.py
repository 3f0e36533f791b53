"""A small template for tests."""

TEXT = """\
dataset:
  seed: 3
  count: 2500
  splits: {train: 0.8, test: 0.2}
  factors: {hue: {linspace: [0, 0.9, 10]}}
  require:
    - {apart: things, margin: 0.25}
    - {in_view: things, margin: 2}
    - {min_visible_pixels: 10, of: things}
    - {min_visible_fraction: 0.3, of: things}
camera: {resolution: [48, 32], fov: {uniform: [35, 45]}, position: [7, 5.5, 7], look_at: [0, 0.3, 0]}
lights:
  - {position: [2, 8, -3], intensity: {log_uniform: [1000, 4000]}}
objects:
  - {type: plane, name: floor, position: [0, 0.5, 0], normal: [0, 2, 0], color: gray}
  - name: things
    repeat: {integers: [3, 6]}
    position: [{uniform: [-3, 3]}, 0, {uniform: [-3, 3]}]
    rest_on: floor
    color: {hsv: [{factor: hue}, 0.9, 0.8]}
    one_of:
      - {type: sphere, radius: {choice: [0.35, 0.7]}}
      - {type: box, size: {all: {choice: [0.7, 1]}}, rotation: {uniform: [0, 360]}}
"""
