"""The scene file's keys: types, ranges, units and defaults, declared once.

Validation, error messages, the JSON Schema and the reference page are all made from these records. They are
plain frozen data: nothing here knows Dr.Jit, so converters read the same description that the renderer compiles.
Lengths are in scene units, angles in degrees, colours linear RGB; vectors are written `[x, y, z]`.
"""

from __future__ import annotations

from renderer.scene.composed import OneOf, Record, Rows
from renderer.scene.materials import MATERIAL, PLAIN, Material
from renderer.scene.nodes import Node, key, node
from renderer.scene.quantities import (
    BLACK, COLOUR, DEGREES, DIRECTION, HALF_SPACE, LENGTH, NON_NEGATIVE, POINT, POSITIVE, REAL, UV, WHITE, kind,
)
from renderer.scene.values import FILE_NAME, Choice, Factors, Flag, Integer, Optional, Vector

PATHTRACER = "pathtracer"
SHADED_MODES = ("phong", PATHTRACER)  # show light: are tone mapped, and have an albedo
SAMPLED_MODES = ("binary", *SHADED_MODES)
DEBUG_MODES = ("depth", "normals", "uv", "albedo", "shapes")
RENDER_MODES = SAMPLED_MODES + DEBUG_MODES
FILTERS = ("box", "tent", "gaussian", "mitchell")
SAMPLERS = ("sobol", "independent")
PATH_SAMPLES = 64  # a pixel where the file does not tell

TONEMAPS = ("linear", "reinhard", "filmic")
MAX_SIDE = 65_536  # pixels
MAX_PIXELS = 2**28  # pixels: a float32 film of 3 GiB
MAX_SAMPLES = 2**24  # a pixel
MAX_BOUNCES = 64


def material():
    """Return the declaration of a shape's `material`."""
    return key(MATERIAL, "what it is made of (see Material); absent: all defaults", default=PLAIN)


def emission():
    """Return the declaration of a shape's `emission`."""
    return key(
        COLOUR, "radiance that it emits in mode `pathtracer`: solids and meshes outwards, flat shapes on both sides",
        default=BLACK,
    )


@node
class Sphere(Node):
    """A sphere; uv: longitude around +y, and latitude from the top (v = 0) down."""

    type: str = kind("sphere")
    center: tuple = key(POINT, "centre", unit=LENGTH)
    radius: float = key(POSITIVE, "radius", unit=LENGTH)
    material: Material = material()
    emission: tuple = emission()


@node
class Cylinder(Node):
    """A capped cylinder; uv: angle around the axis, and v along the axis, from the centre outwards on the caps."""

    type: str = kind("cylinder")
    center: tuple = key(POINT, "centre", unit=LENGTH)
    axis: tuple = key(DIRECTION, "direction of the axis, of any length but 0")
    radius: float = key(POSITIVE, "radius", unit=LENGTH)
    height: float = key(
        POSITIVE, "**half** the length: the cylinder ends at center +- height * unit axis", unit=LENGTH
    )
    material: Material = material()
    emission: tuple = emission()


@node
class Triangle(Node):
    """A triangle seen from both sides; uv is interpolated between the corners."""

    type: str = kind("triangle")
    v0: tuple = key(POINT, "first corner", unit=LENGTH)
    v1: tuple = key(POINT, "second corner", unit=LENGTH)
    v2: tuple = key(POINT, "third corner", unit=LENGTH)
    uv0: tuple = key(UV, "texture coordinates at v0", default=(0.0, 0.0))
    uv1: tuple = key(UV, "texture coordinates at v1", default=(1.0, 0.0))
    uv2: tuple = key(UV, "texture coordinates at v2", default=(0.0, 1.0))
    material: Material = material()
    emission: tuple = emission()


@node
class Plane(Node):
    """An infinite plane seen from both sides; uv: distances from `point` along two axes of the plane."""

    type: str = kind("plane")
    point: tuple = key(POINT, "any point of the plane; uv = (0, 0) lies here", unit=LENGTH)
    normal: tuple = key(DIRECTION, "normal, of any length but 0")
    material: Material = material()
    emission: tuple = emission()


@node
class Box(Node):
    """An axis-aligned box; every face shows the whole texture."""

    type: str = kind("box")
    min: tuple = key(POINT, "corner with the least coordinates", unit=LENGTH)
    max: tuple = key(POINT, "corner with the greatest coordinates", unit=LENGTH)
    material: Material = material()
    emission: tuple = emission()


@node
class Convex(Node):
    """A convex volume: the intersection of `halfspaces`, or the hull of `vertices` (exactly one is given)."""

    type: str = kind("convex")
    halfspaces: tuple | None = key(
        Rows(HALF_SPACE, "half-spaces [nx, ny, nz, d]", least=1),
        "the points p with n . p <= d for every row `[nx, ny, nz, d]` (n points outwards, of any length but 0)",
        default=None, unit=LENGTH,
    )
    vertices: tuple | None = key(
        Rows(POINT, "points [x, y, z]", least=4), "points whose convex hull is the volume", default=None, unit=LENGTH
    )
    material: Material = material()
    emission: tuple = emission()


@node
class Rotation(Node):
    """A rotation around an axis through the origin, counterclockwise for who looks against the axis."""

    axis: tuple = key(DIRECTION, "direction of the axis, of any length but 0")
    angle: float = key(REAL, "angle", unit="degrees")


@node
class Step(Node):
    """One step of a transformation: exactly one of these keys is given."""

    translate: tuple | None = key(Vector(3, REAL, "an offset [x, y, z]"), "offset", default=None, unit=LENGTH)
    scale: tuple | None = key(
        Factors(REAL), "factor, or one for each axis; negative ones mirror, and turn the shape inside out",
        default=None
    )
    rotate: Rotation | None = key(Record(Rotation), "rotation (see `rotate`)", default=None)
    matrix: tuple | None = key(
        Vector(16, REAL, "a 4 x 4 matrix"), "affine matrix for column vectors, row by row; it is invertible and its "
        "last row is 0, 0, 0, 1", default=None
    )


@node
class Mesh(Node):
    """The triangles in an OBJ or PLY file, seen from both sides; uv is that of the file."""

    type: str = kind("mesh")
    filename: str = key(FILE_NAME, "OBJ or PLY file, relative to the scene file")
    transform: tuple = key(
        Rows(Record(Step), "transformation steps"), "steps (see Step) that bring the file's mesh to its place, in the "
        "order in which they are applied", default=()
    )
    normals: str = key(
        Choice("normals", ("file", "smooth", "flat")),
        "`file`: the vertex normals of the file, flat where it has none; "
        "`smooth`: computed, by angles between edges; `flat`: those of the triangles", default="file"
    )
    material: Material = material()
    emission: tuple = emission()


@node
class Rectangle(Node):
    """A rectangle or parallelogram seen from both sides; uv runs from 0 to 1 along `u` and `v`."""

    type: str = kind("rectangle")
    center: tuple = key(POINT, "its middle", unit=LENGTH)
    u: tuple = key(DIRECTION, "edge, of full length", unit=LENGTH)
    v: tuple = key(DIRECTION, "the other edge; the normal is u x v", unit=LENGTH)
    material: Material = material()
    emission: tuple = emission()


@node
class Disk(Node):
    """A round disk seen from both sides; uv: the angle in turns, and the distance from the middle over the radius."""

    type: str = kind("disk")
    center: tuple = key(POINT, "its middle", unit=LENGTH)
    normal: tuple = key(DIRECTION, "normal, of any length but 0")
    radius: float = key(POSITIVE, "radius", unit=LENGTH)
    material: Material = material()
    emission: tuple = emission()


Shape = Rectangle | Disk | Sphere | Cylinder | Triangle | Plane | Box | Convex | Mesh
SHAPE_KINDS = {made.__name__.lower(): Record(made) for made in (
    Sphere, Cylinder, Triangle, Plane, Box, Convex, Rectangle, Disk, Mesh)}
EXACTLY_ONE = {Convex: ("halfspaces", "vertices"), Step: ("translate", "scale", "rotate", "matrix")}  # of these keys


@node
class PointLight(Node):
    """Light from one point: in `pathtracer` intensity / distance^2 arrives, in phong mode it does not fall off."""

    type: str = kind("pointlight")
    position: tuple = key(POINT, "position", unit=LENGTH)
    intensity: tuple = key(COLOUR, "intensity")


@node
class SpotLight(Node):
    """Light from one point into a cone."""

    type: str = kind("spot")
    position: tuple = key(POINT, "position", unit=LENGTH)
    direction: tuple = key(DIRECTION, "direction of the middle of the cone, of any length but 0")
    intensity: tuple = key(COLOUR, "intensity in the middle of the cone")
    cutoff: float = key(
        DEGREES, "half angle of the cone, outside of which there is no light", default=30.0, unit="degrees"
    )
    beamwidth: float | None = key(
        Optional(NON_NEGATIVE), "half angle within which the intensity is full; from there it falls linearly with "
        "the angle; absent: three quarters of `cutoff`", default=None, unit="degrees"
    )


@node
class DirectionalLight(Node):
    """Light from infinitely far away."""

    type: str = kind("directional")
    direction: tuple = key(DIRECTION, "direction in which the light travels, of any length but 0")
    intensity: tuple = key(COLOUR, "irradiance of a surface that faces the light")


@node
class AreaLight(Node):
    """A shining rectangle: unseen in phong mode, where shadows get soft; black but for its light in `pathtracer`."""

    type: str = kind("arealight")
    position: tuple = key(POINT, "its middle", unit=LENGTH)
    u: tuple = key(DIRECTION, "edge, of full length", unit=LENGTH)
    v: tuple = key(DIRECTION, "the other edge", unit=LENGTH)
    intensity: tuple = key(COLOUR, "radiance; in phong mode the intensity of the light as a whole")
    twosided: bool = key(Flag(), "both sides shine; false: only the side of the normal u x v", default=True)


@node
class DiskLight(Node):
    """A shining disk, otherwise like `arealight`."""

    type: str = kind("disklight")
    position: tuple = key(POINT, "its middle", unit=LENGTH)
    normal: tuple = key(DIRECTION, "normal, of any length but 0")
    radius: float = key(POSITIVE, "radius", unit=LENGTH)
    intensity: tuple = key(COLOUR, "radiance; in phong mode the intensity of the light as a whole")
    twosided: bool = key(Flag(), "both sides shine; false: only the side of the normal", default=True)


@node
class Environment(Node):
    """An image of what is infinitely far away all around; it takes the place of `backgroundcolor`."""

    type: str = kind("environment")
    filename: str = key(
        FILE_NAME, "EXR, HDR, PNG, JPEG or PPM file, relative to the scene file: longitude and latitude, +y up"
    )
    intensity: tuple = key(COLOUR, "factor of the image", default=WHITE)
    rotation: float = key(REAL, "angle by which it is turned around +y", default=0.0, unit="degrees")


LIGHT_KINDS = {"pointlight": Record(PointLight), "spot": Record(SpotLight), "directional": Record(DirectionalLight),
               "arealight": Record(AreaLight), "disklight": Record(DiskLight), "environment": Record(Environment)}


@node
class Camera(Node):
    """A pinhole, a thin lens, or parallel rays: +x of the picture is upVector x forward, rows run from the top."""

    type: str = key(Choice("camera type", ("pinhole", "thinlens", "orthographic")), "kind of camera", default="pinhole")
    width: int = key(Integer(1, MAX_SIDE), "width of the picture", default=1200, unit="pixels")
    height: int = key(Integer(1, MAX_SIDE), "height of the picture", default=800, unit="pixels")
    position: tuple = key(POINT, "position of the eye", unit=LENGTH)
    lookAt: tuple = key(POINT, "point in the middle of the picture", unit=LENGTH)
    upVector: tuple = key(DIRECTION, "direction that is up in the picture", default=(0.0, 1.0, 0.0))
    fov: float = key(DEGREES, "vertical field of view", default=45.0, unit="degrees")
    apertureRadius: float = key(NON_NEGATIVE, "radius of the lens of a `thinlens`", default=0.0, unit=LENGTH)
    focusDistance: float | None = key(
        Optional(POSITIVE), "distance, along the direction of view, of the plane that a `thinlens` shows sharp; "
        "absent: that of lookAt", default=None, unit=LENGTH
    )
    viewHeight: float | None = key(
        Optional(POSITIVE), "height of what an `orthographic` camera shows; absent: of what `fov` shows at lookAt",
        default=None, unit=LENGTH
    )
    exposure: float = key(NON_NEGATIVE, "tone mapping multiplies by exposure / 0.1", default=0.1)


@node
class World(Node):
    """What is in front of the camera."""

    backgroundcolor: tuple = key(COLOUR, "colour of rays that hit nothing", default=BLACK)
    ambientlight: tuple = key(
        COLOUR, "light from everywhere in phong mode, times the diffuse colour", default=(0.4, 0.4, 0.4)
    )
    lightsources: tuple = key(Rows(OneOf("light", LIGHT_KINDS), "lights"), "lights", default=())
    shapes: tuple = key(Rows(OneOf("shape", SHAPE_KINDS), "shapes"), "shapes", default=())


@node
class Scene(Node):
    """A whole scene file."""

    nbounces: int = key(
        Integer(0, MAX_BOUNCES), "greatest number of reflections and refractions; in mode `pathtracer` of bounces of a "
        "path, where 1 is direct light", default=8
    )
    rendermode: str = key(Choice("rendermode", RENDER_MODES), "what is computed", default="phong")
    samples: int | None = key(
        Optional(Integer(1, MAX_SAMPLES)), "rays a pixel; 1 is one ray through its centre but in mode `pathtracer`; "
        f"absent: 1, and {PATH_SAMPLES} in mode `pathtracer`", default=None
    )
    sampler: str = key(
        Choice("sampler", SAMPLERS), "where samples lie: evenly spread (Owen-scrambled Sobol points) or at random",
        default="sobol"
    )
    filter: str = key(Choice("filter", FILTERS), "reconstruction filter of the pixels", default="box")
    roulette: bool = key(Flag(), "in mode `pathtracer`, long paths end at random, so that dim ones do not cost time",
                         default=True)
    mirrorlight: bool = key(Flag(), "in mode `pathtracer`, lamps are also looked for in mirrors: far less noise where "
                            "small lamps shine on mirrors, for more time a sample", default=True)
    tonemap: str = key(Choice("tonemap", TONEMAPS), "curve from radiance to 8 bits", default="linear")
    camera: Camera = key(Record(Camera), "where the picture is taken from (see Camera)")
    scene: World = key(Record(World, partial=True), "what is in it (see World)")

    @property
    def spp(self):
        """Samples a pixel."""
        return self.samples or (PATH_SAMPLES if self.rendermode == PATHTRACER else 1)


def encoding_of(mode):
    """Return how the 8-bit values of a render mode's picture are encoded where nobody says otherwise."""
    return "srgb" if mode == PATHTRACER else "linear"


SCENE = Record(Scene, partial=True)
