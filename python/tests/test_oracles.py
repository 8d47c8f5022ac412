"""Against libraries that share nothing with ylm: scipy's harmonics and quadrature, ducc0's rotation and synthesis."""

from __future__ import annotations

import ducc0
import numpy as np
import pytest
import scipy.special
from scipy.spatial.transform import Rotation

import ylm


def scipy_basis(directions: np.ndarray, bands: int) -> np.ndarray:
    """The real basis by scipy's complex harmonics: sqrt(2) times the real or imaginary part, its phase kept."""
    theta = np.arctan2(np.hypot(directions[..., 0], directions[..., 1]), directions[..., 2])
    phi = np.arctan2(directions[..., 1], directions[..., 0])
    columns = []
    for degree in range(bands):
        for order in range(-degree, degree + 1):
            value = scipy.special.sph_harm_y(degree, abs(order), theta, phi)
            if order == 0:
                columns.append(value.real)
            else:
                columns.append(np.sqrt(2) * (value.real if order > 0 else value.imag))
    return np.stack(columns, axis=-1)


@pytest.mark.parametrize("bands", [1, 2, 7, 32])
def test_basis_and_eval_are_scipys(bands, directions, random):
    expected = scipy_basis(directions, bands)
    found = ylm.basis(directions, bands)
    assert np.abs(found - expected).max() <= 1e-12
    coeffs = random.normal(size=(5, bands**2))
    # The error of the basis, summed over coefficients of size 1.
    assert np.abs(ylm.eval(coeffs, directions) - coeffs @ expected.T).max() <= 1e-12 * bands


@pytest.mark.parametrize("bands", [2, 6, 20])
def test_rotation_is_ducc0s(bands, random):
    coeffs = random.normal(size=bands**2)
    alpha, beta, gamma = random.uniform(-3, 3, 3)
    alm = ylm.convert(coeffs, "ylm", "ducc0")
    turned = ducc0.sht.rotate_alm(alm, bands - 1, alpha, abs(beta), gamma)
    # ducc0 turns by psi about z first, then by theta about y, then by phi about z.
    turn = ylm.Turn.from_euler("zyz", [gamma, abs(beta), alpha])
    found = ylm.rotate(coeffs, turn)
    assert np.abs(found - ylm.convert(turned, "ducc0", "ylm")).max() <= 1e-12


@pytest.mark.parametrize("bands", [3, 10])
def test_rotation_takes_scipys_rotations_one_or_many(bands, random, directions):
    turns = Rotation.random(4, rng=random)
    coeffs = random.normal(size=(4, bands**2))
    found = ylm.rotate(coeffs, turns)
    for row, turn in enumerate(turns):
        there = ylm.eval(found[row], turn.apply(directions))
        assert np.abs(there - ylm.eval(coeffs[row], directions)).max() <= 1e-12 * bands
        assert np.array_equal(ylm.rotate(coeffs[row], turn), found[row])
        assert np.allclose(ylm.rotation_matrix(turn, bands) @ coeffs[row], found[row], rtol=0, atol=1e-12)


def scipy_grid(degree: int) -> tuple[np.ndarray, np.ndarray]:
    """Directions and weights exact to a degree, by scipy's Gauss-Legendre nodes."""
    nodes, weights = scipy.special.roots_legendre(degree // 2 + 1)
    phi = 2 * np.pi * np.arange(degree + 1) / (degree + 1)
    sine = np.sqrt(1 - nodes**2)[:, None]
    z = np.broadcast_to(nodes[:, None], (len(nodes), len(phi)))
    directions = np.stack([sine * np.cos(phi), sine * np.sin(phi), z], axis=-1)
    weights = np.broadcast_to(weights[:, None] * 2 * np.pi / (degree + 1), z.shape)
    return directions.reshape(-1, 3), weights.reshape(-1)


@pytest.mark.parametrize("bands", [2, 5, 9])
@pytest.mark.parametrize("count", [2, 3, 4])
def test_products_are_quadrature_through_scipy(bands, count, random):
    factors = random.normal(size=(count, 6, bands**2))
    directions, weights = scipy_grid((count + 1) * (bands - 1))
    basis = scipy_basis(directions, bands)
    values = np.prod(factors @ basis.T, axis=0)
    expected = (values * weights) @ basis
    scale = np.sqrt((values**2) @ weights)[:, None]
    assert (np.abs(ylm.product(*factors) - expected) / scale).max() <= 1e-13
    single = ylm.product(*factors.astype(np.float32))
    assert single.dtype == np.float32
    assert (np.abs(single - expected) / scale).max() <= 2e-6
    assert np.allclose(ylm.product_integral(*factors), values @ weights, rtol=0, atol=1e-13 * scale.max())
    # The whole product, and a part of it.
    wide = ylm.product(*factors, bands=count * (bands - 1) + 1)
    assert np.abs(ylm.eval(wide, directions) - values).max() <= 1e-11 * np.abs(values).max()
    assert (np.abs(ylm.product(*factors, bands=2) - expected[:, :4]) / scale).max() <= 1e-13


@pytest.mark.parametrize("method", ["unrolled", "gaunt", "fourier", "grid", "grid-in-double"])
def test_every_method_of_products_agrees(method, random):
    f, g = random.normal(size=(2, 30, 25))
    found = ylm.product(f, g, method=method)
    assert np.abs(found - ylm.product(f, g)).max() <= 1e-12


def test_projection_is_scipys_quadrature(random):
    coeffs = random.normal(size=(2, 36))
    found = ylm.project(lambda d: coeffs @ scipy_basis(d, 6).T, bands=6)
    assert np.abs(found - coeffs).max() <= 1e-12
    directions, weights = scipy_grid(10)
    found = ylm.project_values(ylm.eval(coeffs, directions) * weights, directions, 6)
    assert np.abs(found - coeffs).max() <= 1e-12


def test_pictures_are_projected_onto_scipys_basis():
    directions, solid_angles = ylm.image_texels(64, 128)
    assert np.isclose(solid_angles.sum(), 4 * np.pi, rtol=1e-12)
    radiance = 1 + np.stack([directions[..., 0], directions[..., 1], directions[..., 2] ** 2], axis=-1)
    expected = np.einsum("hwc,hwi,hw->ci", radiance, scipy_basis(directions, 3), solid_angles)
    # Harmonics vary over a texel of 3 degrees by their curvature: (0.05)² / 24 · l(l+1).
    assert np.abs(ylm.project_image(radiance, 3, "latlong") - expected).max() <= 5e-3
    grey = ylm.project_image(radiance[..., 1], 3)
    assert np.array_equal(grey, ylm.project_image(radiance, 3)[1])


def test_a_zonal_kernel_convolves_as_quadrature_does(random, directions):
    coeffs = random.normal(size=25)
    grid, weights = scipy_grid(300)
    kernel = np.maximum(directions @ grid.T, 0) ** 3
    expected = (kernel * weights) @ (scipy_basis(grid, 5) @ coeffs)
    found = ylm.eval(ylm.convolve(coeffs, ylm.zonal.phong(3, 5)), directions)
    # The kink of the kernel, by a rule of degree 300: measured 4e-6.
    assert np.abs(found - expected).max() <= 2e-5


@pytest.mark.parametrize("bands", [4, 8])
def test_the_gaunt_tensor_is_quadrature(bands):
    directions, weights = scipy_grid(3 * (bands - 1))
    basis = scipy_basis(directions, bands)
    dense = np.einsum("d,di,dj,dk->ijk", weights, basis, basis, basis, optimize=True)
    indices, values = ylm.gaunt(bands)
    i, j, k = indices.T
    assert np.abs(dense[i, j, k] - values).max() <= 1e-14
    dense[i, j, k] = 0
    assert np.abs(dense).max() <= 1e-14
    assert ylm.tripling_coefficient(*indices[7]) == pytest.approx(values[7], abs=1e-15)


@pytest.mark.parametrize("degree", [20, 100, 250])
def test_a_grid_integrates_harmonics_up_to_its_degree(degree):
    directions, weights = ylm.sphere_grid(degree)
    integrals = ylm.project_values(weights, directions, degree + 1)
    integrals[0] -= np.sqrt(4 * np.pi)
    # Measured 5e-14 at degree 250.
    assert np.abs(integrals).max() <= 1e-13


@pytest.mark.parametrize(
    "layout, shape",
    [("latlong", (32, 64)), ("cube-column", (96, 16)), ("angular", (64, 64)), ("mirror", (64, 64)), ("vertical-cross", (64, 48))],
)
def test_the_texels_of_a_layout_cover_the_sphere_once(layout, shape):
    _, solid_angles = ylm.image_texels(*shape, layout)
    # Measured 3e-14 for the angular map.
    assert abs(solid_angles.sum() / (4 * np.pi) - 1) <= 1e-13


def upper_hemisphere(degree: int) -> tuple[np.ndarray, np.ndarray]:
    """Directions and weights of the hemisphere around +z, exact to a degree: what a clamped cosine does not cut is a polynomial."""
    nodes, weights = scipy.special.roots_legendre(degree // 2 + 1)
    nodes, weights = 0.5 * (nodes + 1), 0.5 * weights
    phi = 2 * np.pi * np.arange(degree + 1) / (degree + 1)
    sine = np.sqrt(1 - nodes**2)[:, None]
    z = np.broadcast_to(nodes[:, None], (len(nodes), len(phi)))
    directions = np.stack([sine * np.cos(phi), sine * np.sin(phi), z], axis=-1)
    weights = np.broadcast_to(weights[:, None] * 2 * np.pi / (degree + 1), z.shape)
    return directions.reshape(-1, 3), weights.reshape(-1)


@pytest.mark.parametrize("bands", [1, 3, 9])
def test_a_product_with_the_whole_cosine_is_quadrature_over_its_hemisphere(bands, random):
    coeffs, axes = random.normal(size=(4, bands**2)), random.normal(size=(4, 3))
    directions, weights = upper_hemisphere(2 * bands)
    basis = scipy_basis(directions, bands)
    weighted = basis * (weights * directions[:, 2])[:, None]
    cosine = ylm.AxialProduct.clamped_cosine(bands)
    expected = coeffs @ basis.T @ weighted
    norm = np.linalg.norm(coeffs, axis=-1, keepdims=True)
    assert (np.abs(cosine.in_frame(coeffs) - expected) / norm).max() <= 1e-13
    single = cosine.in_frame(coeffs.astype(np.float32))
    assert single.dtype == np.float32 and (np.abs(single - expected) / norm).max() <= 2e-6
    # In the world, by scipy's rotation of the quadrature's directions.
    turned = ylm.rotate_into_frames(coeffs, axes)
    assert np.allclose(cosine.into_frames(coeffs, axes), cosine.in_frame(turned), rtol=0, atol=1e-13 * norm.max())
    for row, axis in enumerate(axes):
        there = Rotation.align_vectors([axis], [[0, 0, 1]])[0].apply(directions)
        basis = scipy_basis(there, bands)
        expected = (coeffs[row] @ basis.T * weights * directions[:, 2]) @ basis
        assert np.abs(cosine.in_world(coeffs, axes)[row] - expected).max() <= 1e-13 * norm[row]


def test_turned_products_are_products_with_the_turned_kernel(random):
    f, d = random.normal(size=(3, 1, 36)), random.normal(size=(5, 3))
    for kernel in (ylm.zonal.clamped_cosine(3), ylm.zonal.phong(4, 6)):
        padded = np.pad(kernel, (0, 6 - len(kernel)))
        found = ylm.TurnedProduct(kernel, 6).product(f, d)
        assert found.shape == (3, 5, 36)
        assert np.abs(found - ylm.product(f, ylm.zonal.rotate(padded, d))).max() <= 1e-12


def test_products_by_the_full_tensor_agree(random):
    factors = random.normal(size=(3, 2, 9))
    assert np.abs(ylm.product(*factors, method="brute-force") - ylm.product(*factors)).max() <= 1e-12


def test_integrals_by_band_sum_up_to_the_quadrature(random):
    f, g, h = random.normal(size=(2, 25)), random.normal(size=25), random.normal(size=25)
    directions, weights = scipy_grid(12)
    basis = scipy_basis(directions, 5)
    found = ylm.band_integrals(f, g, h)
    for bands in range(1, 6):
        count = bands**2
        values = (f[:, :count] @ basis[:, :count].T) * (basis[:, :count] @ g[:count]) * (basis @ h)
        assert np.abs(found[:, :bands].sum(axis=-1) - values @ weights).max() <= 1e-12


def test_lobes_are_scipys_quadrature():
    nodes, weights = scipy.special.roots_legendre(400)
    legendre = np.sqrt((2 * np.arange(7) + 1) / (4 * np.pi)) * scipy.special.eval_legendre(np.arange(7), nodes[:, None])
    g = -0.4
    values = (1 - g * g) / (4 * np.pi) / (1 + g * g - 2 * g * nodes) ** 1.5
    expected = 2 * np.pi * (weights * values) @ legendre
    assert np.abs(ylm.zonal.henyey_greenstein(g, 7) - expected).max() <= 1e-13
    # Straight pieces, each by a rule of its own.
    table = np.array([[-1.0, 0.5], [-0.2, 0.1], [0.3, 2.0], [0.9, 0.0]])
    expected = np.zeros(7)
    for (x0, y0), (x1, y1) in zip(table, table[1:]):
        x = x0 + 0.5 * (nodes + 1) * (x1 - x0)
        y = y0 + (x - x0) / (x1 - x0) * (y1 - y0)
        rows = np.sqrt((2 * np.arange(7) + 1) / (4 * np.pi)) * scipy.special.eval_legendre(np.arange(7), x[:, None])
        expected += 2 * np.pi * 0.5 * (x1 - x0) * (weights * y) @ rows
    assert np.abs(ylm.zonal.tabulated(*table.T, 7) - expected).max() <= 1e-12
    assert np.abs(ylm.legendre(0, 7, nodes) - legendre).max() <= 1e-13
    found = ylm.zonal.multiply(expected, expected, expected)
    nodes, weights = scipy.special.roots_legendre(30)
    rows = np.sqrt((2 * np.arange(7) + 1) / (4 * np.pi)) * scipy.special.eval_legendre(np.arange(7), nodes[:, None])
    assert np.abs(found - 2 * np.pi * (weights * (rows @ expected) ** 3) @ rows).max() <= 1e-12


def test_wigners_symbols_are_orthogonal():
    for l3 in range(5):
        for m3 in range(-l3, l3 + 1):
            total = sum(
                (2 * l3 + 1) * ylm.wigner_3j((3, 2, l3), (m1, m2, m3)) ** 2 for m1 in range(-3, 4) for m2 in range(-2, 3)
            )
            assert total == pytest.approx(1.0 if 1 <= l3 <= 5 else 0.0, abs=1e-13)
    assert ylm.wigner_3j((3, 2, 5), (1, 1, -2)) != 0


@pytest.mark.parametrize(
    "layout, shape",
    [("latlong", (16, 32)), ("cube-column", (48, 8)), ("angular", (32, 32)), ("mirror", (32, 32)), ("horizontal-cross", (24, 32))],
)
def test_texels_are_found_where_they_look(layout, shape):
    directions, solid_angles = ylm.image_texels(*shape, layout)
    shown = solid_angles > 0
    rows, columns = ylm.image_locate(directions[shown] * 3.0, *shape, layout)
    assert np.array_equal(np.argwhere(shown), np.stack([rows, columns], axis=-1))
