"""The words that other programs use for the keys of a scene, for the shapes and for the lights.

All are in lower case, without hyphens and underscores.
"""

from __future__ import annotations

# By the name of a shape.
WORDS_FOR_SHAPES = {
    "sphere": "ball orb globe bubble marble bead planet uvsphere icosphere ellipsoid spheroid",
    "plane": "floor ground wall ceiling surface backdrop infiniteplane halfspace sheet quad",
    "box": "cube cuboid block brick crate rectangle rect rectangularprism prism slab rectcuboid hexahedron aabb",
    "cylinder": "tube pipe rod column pillar pole post disc disk puck tin can drum barrel circularcylinder",
    "capsule": "pill lozenge stadium sausage roundedcylinder spherocylinder sweptsphere",
    "cone": "frustum funnel taper truncatedcone conicalfrustum conefrustum pyramid",
}

# By the type of a light.
WORDS_FOR_LIGHTS = {
    "point": "pointlight pointlamp lamp bulb omni omnilight positional sphere",
    "sun": "sunlight sunlamp directional directionallight distant distantlight parallel parallellight infinite "
    "daylight",
}


# By the value of a key that takes one of a few words.
WORDS_FOR_CHOICES = {
    "orthographic": "ortho orth orthogonal parallel isometric axonometric",
    "perspective": "persp pinhole thinlens central",
}


def plural(shape: str) -> str:
    """Return the plural of a shape's name."""
    return shape + ("es" if shape.endswith("x") else "s")


_SHAPES_AND_PLURALS = " ".join(f"{shape} {plural(shape)}" for shape in WORDS_FOR_SHAPES)

# By the key. A word may stand for several keys: it means the first that the mapping has, but a missing one before
# the others.
WORDS_FOR_KEYS = {
    "camera": "cam cameras eye viewer viewpoint sensor view perspective resolution fov fieldofview lookat",
    "lights": "light lamp lamps lightsource lightsources pointlight pointlights emitter emitters luminaires",
    "objects": "shape shapes primitive primitives geometry geometries mesh meshes entity entities thing things "
    f"item items body bodies model models world scene {_SHAPES_AND_PLURALS}",
    "render": "renderer rendering settings integrator options background samples spp maxdepth eyefalloff",
    "image": "film output picture exposure tone tonemap tonemapping display",
    "version": "format formatversion schemaversion",
    "type": "kind shape primitive geometry class object",
    "position": "center centre location origin pos translate translation point place at offset eye from lookfrom "
    "cameraposition xyz coordinates coords",
    "look_at": "lookat target to at lookto focus aim pointat direction interest viewat",
    "up": "vup upvector updirection worldup",
    "resolution": "size dimensions width height imagesize pixels filmsize res",
    "fov": "angle fieldofview fovy vfov yfov viewangle fovdegrees",
    "fov_x": "hfov xfov fovh horizontalfov horizontalfieldofview cameraanglex",
    "intrinsics": "k kmatrix intrinsic intrinsicmatrix cameramatrix calibration calibrationmatrix focal "
    "focallength f fx fy flx fly cx cy principalpoint",
    "projection": "type kind mode model cameratype ortho orthographic parallel isometric perspective",
    "height": "orthoscale orthosize orthoheight orthographicscale orthographicsize orthographicheight viewheight "
    "frustumheight ymag h length len tall size depth heightz heighty",
    "opencv": "cv c2w camtoworld cam2world cameratoworld pose extrinsics extrinsic w2c worldtocamera rt",
    "opengl": "gl transform transformmatrix matrix matrixworld toworld modelmatrix",
    "camera_to_world": "c2w camtoworld cam2world pose matrix transform transformmatrix matrixworld toworld",
    "world_to_camera": "w2c worldtocam world2cam extrinsics extrinsic view viewmatrix rt",
    "intensity": "power energy brightness strength watts wattage emission emitted flux radiance luminosity lumens",
    "irradiance": "intensity power energy brightness strength illuminance lux radiance flux watts emission",
    "direction": "dir toward towards target to at lookat aim from orientation heading rotation normal vector way",
    "color": "colour rgb rgba albedo material diffuse diffusecolor basecolor reflectance reflectivity kd tint "
    "surface paint pigment texture hue",
    "name": "id label title identifier",
    "normal": "n norm direction orientation facing up",
    "axis": "direction axisdirection dir orientation normal up along rotation",
    "top_radius": "radiustop toprad topradius r2 radius2 radiusupper upperradius capradius smallradius",
    "size": "dimensions dimension dims dim extent extents scale sides side edge edges lengths halfsize "
    "halfextents halfextent width height depth length",
    "radius": "r rad diameter size scale width baseradius radiusbottom bottomradius r1 radius1",
    "rotation": "rotate rotated rot angle yaw turn heading orientation rotationy rotatey degrees",
    "checker": "checkers checkerboard chessboard chess pattern texture tiles squares grid",
    "light": "lights lamp emission emissive emitter emit emits lightsource glow pointlight",
    "samples": "spp samplesperpixel samplecount antialiasing aa rays raysperpixel",
    "background": "sky skycolor backgroundcolor bg backdrop environment",
    "ambient": "ambientlight ambientcolor ambientradiance ambientintensity globalambient skylight filllight fill",
    "max_depth": "depth bounces maxbounces recursion recursiondepth maxrecursion raydepth",
    "shadow_samples": "shadowrays lightsamples emittersamples softshadows areasamples",
    "angle": "angulardiameter diameter size radius softness degrees",
    "eye_falloff": "falloff attenuation eyeattenuation",
    "exposure": "ev stops brightness gain",
    "alpha": "transparent transparency transparentbackground filmtransparent opacity rgba",
    "tone": "tonemap tonemapping tonemapper tonecurve curve mapping operator filmic",
}
