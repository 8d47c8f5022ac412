"""Each convention against the library that has it."""

from __future__ import annotations

import ducc0
import numpy as np
import pytest
import scipy.special

import ylm

BANDS = 5
FLAT = ["ylm", "no-phase", "threejs", "sphericart", "four-pi", "pyshtools", "e3nn", "scipy", "healpix", "healpy", "ducc0"]


@pytest.fixture
def coeffs(random):
    return random.normal(size=(3, BANDS**2))


@pytest.fixture
def values(coeffs, directions):
    return ylm.eval(coeffs, directions)


def angles(directions):
    theta = np.arctan2(np.hypot(directions[:, 0], directions[:, 1]), directions[:, 2])
    return theta, np.arctan2(directions[:, 1], directions[:, 0]) % (2 * np.pi)


@pytest.mark.parametrize("source", FLAT)
@pytest.mark.parametrize("target", FLAT)
def test_there_and_back_is_the_same(source, target, coeffs):
    first = ylm.convert(coeffs, "ylm", source)
    second = ylm.convert(first, source, target)
    assert np.abs(ylm.convert(second, target, "ylm") - coeffs).max() <= 1e-13
    single = ylm.convert(coeffs.astype(np.float32), "ylm", target)
    assert single.real.dtype == np.float32


def test_scipy(coeffs, values, directions):
    theta, phi = angles(directions)
    alm = ylm.convert(coeffs, "ylm", "scipy")
    total = 0
    for degree in range(BANDS):
        for order in range(-degree, degree + 1):
            harmonic = scipy.special.sph_harm_y(degree, order, theta, phi)
            total = total + alm[:, degree * (degree + 1) + order, None] * harmonic
    assert np.abs(total - values).max() <= 1e-12


def test_ducc0(coeffs, values, directions):
    where = np.stack(angles(directions), axis=-1)
    for row in range(3):
        alm = ylm.convert(coeffs[row : row + 1], "ylm", "ducc0")
        found = ducc0.sht.synthesis_general(alm=alm, spin=0, lmax=BANDS - 1, loc=where, epsilon=1e-12)
        assert np.abs(found[0] - values[row]).max() <= 1e-10


def test_sphericart(coeffs, values, directions):
    sphericart = pytest.importorskip("sphericart")
    harmonics = sphericart.SphericalHarmonics(l_max=BANDS - 1).compute(directions)
    found = ylm.convert(coeffs, "ylm", "sphericart") @ harmonics.T
    assert np.abs(found - values).max() <= 1e-12


def test_pyshtools(coeffs, values, directions):
    pyshtools = pytest.importorskip("pyshtools")
    theta, phi = np.degrees(angles(directions))
    cilm = ylm.convert(coeffs, "ylm", "pyshtools")
    for row in range(3):
        function = pyshtools.SHCoeffs.from_array(cilm[row])
        found = function.expand(lat=90 - theta, lon=phi)
        assert np.abs(found - values[row]).max() <= 1e-12


def test_e3nn_jax(coeffs, values, directions):
    e3nn = pytest.importorskip("e3nn_jax")
    harmonics = e3nn.spherical_harmonics(
        e3nn.s2_irreps(BANDS - 1),
        e3nn.IrrepsArray("1o", directions.astype(np.float32)),
        normalize=True,
        normalization="integral",
    )
    found = ylm.convert(coeffs, "ylm", "e3nn") @ np.asarray(harmonics.array, np.float64).T
    # e3nn-jax computes in float32.
    assert np.abs(found - values).max() <= 2e-5


def splat_colour(sh, direction):
    """The colour of a splat, of 3 degrees, as the rasterizer of Kerbl et al. 2023 computes it (forward.cu)."""
    x, y, z = direction
    c2 = [1.0925484305920792, -1.0925484305920792, 0.31539156525252005, -1.0925484305920792, 0.5462742152960396]
    c3 = [
        -0.5900435899266435,
        2.890611442640554,
        -0.4570457994644658,
        0.3731763325901154,
        -0.4570457994644658,
        1.445305721320277,
        -0.5900435899266435,
    ]
    result = 0.28209479177387814 * sh[0]
    result = result + 0.4886025119029199 * (-y * sh[1] + z * sh[2] - x * sh[3])
    xx, yy, zz, xy, yz, xz = x * x, y * y, z * z, x * y, y * z, x * z
    second = [xy, yz, 2 * zz - xx - yy, xz, xx - yy]
    result = result + sum(c * f * s for c, f, s in zip(c2, second, sh[4:9]))
    third = [
        y * (3 * xx - yy),
        xy * z,
        y * (4 * zz - xx - yy),
        z * (2 * zz - 3 * xx - 3 * yy),
        x * (4 * zz - xx - yy),
        z * (xx - yy),
        x * (xx - 3 * yy),
    ]
    result = result + sum(c * f * s for c, f, s in zip(c3, third, sh[9:16]))
    return result + 0.5


def test_splat(random, directions):
    splats = random.normal(size=(7, 16, 3))
    coeffs = ylm.convert(splats, "splat", "ylm")
    found = ylm.eval(coeffs, directions)
    for index, direction in enumerate(directions):
        expected = np.stack([splat_colour(splat, direction) for splat in splats])
        assert np.abs(found[:, :, index] - expected).max() <= 1e-12
    assert np.abs(ylm.convert(coeffs, "ylm", "splat") - splats).max() <= 1e-13


def test_threejs(coeffs, values, directions):
    """SphericalHarmonics3.getAt has three bands; its constants are given with six digits."""
    sh = ylm.convert(coeffs[:, :9], "ylm", "threejs")[:, :, None]
    x, y, z = directions.T
    found = 0.282095 * sh[:, 0]
    found = found + 0.488603 * (sh[:, 1] * y + sh[:, 2] * z + sh[:, 3] * x)
    found = found + 1.092548 * (sh[:, 4] * x * y + sh[:, 5] * y * z + sh[:, 7] * x * z)
    found = found + 0.315392 * sh[:, 6] * (3 * z * z - 1) + 0.546274 * sh[:, 8] * (x * x - y * y)
    assert np.abs(found - ylm.eval(coeffs[:, :9], directions)).max() <= 2e-5


def test_what_is_not_of_the_convention_is_refused(coeffs):
    with pytest.raises(ValueError, match='no convention "sanskrit"; expected one of ylm'):
        ylm.convert(coeffs, "ylm", "sanskrit")
    with pytest.raises(ValueError, match=r"shape \(3, 24\); expected \(\.\.\., n²\)"):
        ylm.convert(coeffs[:, :24], "threejs", "ylm")
    with pytest.raises(ValueError, match=r"expected \(\.\.\., n\(n\+1\)/2\)"):
        ylm.convert(coeffs[:, :8], "healpix", "ylm")
    with pytest.raises(ValueError, match="complex function"):
        ylm.convert(coeffs * 1j, "scipy", "ylm")
    with pytest.raises(ValueError, match=r"expected \(\.\.\., 2, n, n\)"):
        ylm.convert(coeffs, "pyshtools", "ylm")
    with pytest.raises(ValueError, match=r"expected \(\.\.\., n², 3\)"):
        ylm.convert(coeffs, "splat", "ylm")
    with pytest.raises(TypeError, match="expected real numbers"):
        ylm.convert(coeffs * 1j, "threejs", "ylm")
