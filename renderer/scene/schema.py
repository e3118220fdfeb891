"""The scene file's keys: types, ranges, units and defaults, declared once.

Validation, error messages, the JSON Schema and the reference page are all made from these records. They are
plain frozen data: nothing here knows Dr.Jit, so converters read the same description that the renderer compiles.
Lengths are in scene units, angles in degrees, colours linear RGB; vectors are written `[x, y, z]`.
"""

from __future__ import annotations

from renderer.scene.composed import OneOf, Record, Rows, TextureSource
from renderer.scene.nodes import Node, key, node
from renderer.scene.values import FILE_NAME, Choice, Factors, Flag, Integer, Number, Vector

PHONG_MODES = ("binary", "phong")
DEBUG_MODES = ("depth", "normals", "uv", "albedo", "shapes")
RENDER_MODES = PHONG_MODES + DEBUG_MODES
TONEMAPS = ("linear", "reinhard", "filmic")
MAX_SIDE = 65_536  # pixels
MAX_PIXELS = 2**28  # pixels: a float32 film of 3 GiB
MAX_SAMPLES = 2**24  # a pixel
MAX_BOUNCES = 64

REAL = Number()
POSITIVE = Number(low=0.0, low_open=True)
NON_NEGATIVE = Number(low=0.0)
FRACTION = Number(low=0.0, high=1.0)
DEGREES = Number(low=0.0, high=180.0, low_open=True, high_open=True)
POINT = Vector(3, REAL, "a point [x, y, z]")
DIRECTION = Vector(3, REAL, "a direction [x, y, z]")
UV = Vector(2, REAL, "texture coordinates [u, v]")
COLOUR = Vector(3, NON_NEGATIVE, "a colour [r, g, b]")
HALF_SPACE = Vector(4, REAL, "a half-space [nx, ny, nz, d]")
BLACK, WHITE = (0.0, 0.0, 0.0), (1.0, 1.0, 1.0)
LENGTH = "scene units"


def kind(name):
    """Return the declaration of a `type` key that must read `name`."""
    return key(Choice("type", (name,)), f'`"{name}"`', default=name, required=True)


@node
class Checkerboard(Node):
    """Two colours in squares; `scale` squares along each texture axis."""

    type: str = kind("checkerboard")
    color1: tuple = key(COLOUR, "colour of the square at uv = (0, 0)", default=BLACK)
    color2: tuple = key(COLOUR, "colour of its neighbours", default=WHITE)
    scale: float = key(POSITIVE, "squares along each axis for uv from 0 to 1", default=8.0)


TEXTURE = TextureSource(OneOf("texture", {"checkerboard": Record(Checkerboard)}))


@node
class Material(Node):
    """The coursework's Blinn-Phong material, optionally textured."""

    ks: float = key(NON_NEGATIVE, "weight of the highlight", default=0.1)
    kd: float = key(NON_NEGATIVE, "weight of the diffuse term", default=0.9)
    specularexponent: float = key(NON_NEGATIVE, "exponent of the highlight; 0 gives a constant", default=20.0)
    diffusecolor: tuple = key(COLOUR, "diffuse colour, where there is no texture", default=(0.8, 0.8, 0.8))
    specularcolor: tuple = key(COLOUR, "colour of the highlight", default=WHITE)
    isreflective: bool = key(Flag(), "a mirror's share is mixed in, weighted by `reflectivity`", default=False)
    reflectivity: float = key(
        FRACTION, "share of mirror or glass; counts only with `isreflective` or `isrefractive`", default=1.0
    )
    isrefractive: bool = key(Flag(), "that share is glass: Fresnel reflection and refraction", default=False)
    refractiveindex: float = key(POSITIVE, "index of refraction inside, relative to vacuum", default=1.0)
    texture: str | Checkerboard | None = key(
        TEXTURE, "image file (PPM, PNG or JPEG; relative to the scene file) or checkerboard: replaces `diffusecolor`",
        default=None,
    )
    texturefilter: str = key(
        Choice("texture filter", ("nearest", "bilinear")), "how texels are combined", default="bilinear"
    )
    texturewrap: str = key(
        Choice("texture wrap", ("repeat", "clamp")), "what lies outside 0 <= u, v <= 1", default="repeat"
    )
    scaleU: float = key(POSITIVE, "repetitions of the texture along u", default=1.0)
    scaleV: float = key(POSITIVE, "repetitions of the texture along v", default=1.0)


MATERIAL = Record(Material, shared=True)
PLAIN = Material()


def material():
    """Return the declaration of a shape's `material`."""
    return key(MATERIAL, "what it is made of (see Material); absent: all defaults", default=PLAIN)


@node
class Sphere(Node):
    """A sphere; uv: longitude around +y, and latitude from the top (v = 0) down."""

    type: str = kind("sphere")
    center: tuple = key(POINT, "centre", unit=LENGTH)
    radius: float = key(POSITIVE, "radius", unit=LENGTH)
    material: Material = material()


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


@node
class Plane(Node):
    """An infinite plane seen from both sides; uv: distances from `point` along two axes of the plane."""

    type: str = kind("plane")
    point: tuple = key(POINT, "any point of the plane; uv = (0, 0) lies here", unit=LENGTH)
    normal: tuple = key(DIRECTION, "normal, of any length but 0")
    material: Material = material()


@node
class Box(Node):
    """An axis-aligned box; every face shows the whole texture."""

    type: str = kind("box")
    min: tuple = key(POINT, "corner with the least coordinates", unit=LENGTH)
    max: tuple = key(POINT, "corner with the greatest coordinates", unit=LENGTH)
    material: Material = material()


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


Shape = Sphere | Cylinder | Triangle | Plane | Box | Convex | Mesh
SHAPE_KINDS = {made.__name__.lower(): Record(made) for made in (Sphere, Cylinder, Triangle, Plane, Box, Convex, Mesh)}
EXACTLY_ONE = {Convex: ("halfspaces", "vertices"), Step: ("translate", "scale", "rotate", "matrix")}  # of these keys


@node
class PointLight(Node):
    """Light from one point, with hard shadows; in phong mode it does not fall off with distance."""

    type: str = kind("pointlight")
    position: tuple = key(POINT, "position", unit=LENGTH)
    intensity: tuple = key(COLOUR, "intensity")


LIGHT_KINDS = {"pointlight": Record(PointLight)}


@node
class Camera(Node):
    """A pinhole camera: +x of the picture is upVector x forward, rows run from the top."""

    type: str = key(Choice("camera type", ("pinhole",)), '`"pinhole"`', default="pinhole")
    width: int = key(Integer(1, MAX_SIDE), "width of the picture", default=1200, unit="pixels")
    height: int = key(Integer(1, MAX_SIDE), "height of the picture", default=800, unit="pixels")
    position: tuple = key(POINT, "position of the eye", unit=LENGTH)
    lookAt: tuple = key(POINT, "point in the middle of the picture", unit=LENGTH)
    upVector: tuple = key(DIRECTION, "direction that is up in the picture", default=(0.0, 1.0, 0.0))
    fov: float = key(DEGREES, "vertical field of view", default=45.0, unit="degrees")
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

    nbounces: int = key(Integer(0, MAX_BOUNCES), "greatest number of reflections and refractions", default=8)
    rendermode: str = key(Choice("rendermode", RENDER_MODES), "what is computed", default="phong")
    samples: int = key(Integer(1, MAX_SAMPLES), "rays a pixel; 1 is one ray through its centre", default=1)
    tonemap: str = key(Choice("tonemap", TONEMAPS), "curve from radiance to 8 bits", default="linear")
    camera: Camera = key(Record(Camera), "where the picture is taken from (see Camera)")
    scene: World = key(Record(World, partial=True), "what is in it (see World)")


SCENE = Record(Scene, partial=True)
