"""Shapes, precisions, copies, and what is refused."""

from __future__ import annotations

import threading

import numpy as np
import pytest

import ylm

CALLS = [
    lambda c: ylm.eval(c, np.array([0.0, 0.6, 0.8], c.dtype)),
    lambda c: ylm.rotate(c, [0.1, 0.2, 0.3, 0.9]),
    lambda c: ylm.rotate_z(c, 0.4),
    lambda c: ylm.product(c, c),
    lambda c: ylm.product_integral(c, c, c),
    lambda c: ylm.product_matrix(c),
    lambda c: ylm.convolve(c, ylm.zonal.clamped_cosine(3).astype(c.dtype)),
    lambda c: ylm.zonal.product(c, ylm.zonal.phong(4, 3).astype(c.dtype)),
    lambda c: ylm.window(c, "hann", 3),
    lambda c: ylm.exp(c),
    lambda c: ylm.dot(c, c),
    lambda c: ylm.cap_product(c, np.array([0, 0, 1], c.dtype), 0.5),
    lambda c: ylm.AxialProduct.clamped_cosine(3).in_world(c, [1.0, 2.0, 3.0]),
    lambda c: ylm.TurnedProduct([1.0, 2.0], 3).product(c, [1.0, 2.0, 3.0]),
    lambda c: ylm.rotate_into_frames(c, [1.0, 2.0, 3.0]),
    lambda c: ylm.rotate_frames(c, np.array([0, 0.6, 0.8], c.dtype), np.array([1, 0], c.dtype)),
]


@pytest.mark.parametrize("call", CALLS)
@pytest.mark.parametrize("dtype", [np.float32, np.float64])
def test_rows_are_independent_of_layout_and_keep_their_precision(call, dtype, random):
    coeffs = random.uniform(0.1, 1, size=(2, 3, 9)).astype(dtype)
    whole = call(coeffs)
    assert whole.dtype == dtype
    assert whole.shape[:2] == (2, 3)
    for where in np.ndindex(2, 3):
        alone = call(coeffs[where])
        scale = np.abs(whole[where]).max()
        assert np.abs(np.asarray(alone) - whole[where]).max() <= 4e-6 * scale
    fortran = np.asfortranarray(coeffs)
    assert np.array_equal(call(fortran), whole)
    spread = np.zeros((4, 3, 18), dtype)
    spread[::2, :, ::2] = coeffs
    assert np.array_equal(call(spread[::2, :, ::2]), whole)
    swapped = coeffs.astype(coeffs.dtype.newbyteorder())
    if call is not CALLS[0]:
        assert np.array_equal(call(swapped), whole)
    assert call(coeffs[:0]).shape == (0,) + whole.shape[1:]


def test_misaligned_numbers_are_read_right():
    raw = np.zeros(9 * 8 + 1, np.uint8)
    misaligned = raw[1:].view(np.float64)
    misaligned[:] = np.arange(9)
    assert not misaligned.flags.aligned
    assert np.array_equal(ylm.rotate_z(misaligned, 0.3), ylm.rotate_z(np.arange(9.0), 0.3))


def test_other_numbers_become_double_and_lists_follow_the_arrays_beside_them(random):
    assert ylm.basis([0, 0, 1], 2).dtype == np.float64
    assert ylm.rotate_z(np.arange(4, dtype=np.int16), 0.0).dtype == np.float64
    assert ylm.eval(np.ones(4, np.float32), [0, 0, 1]).dtype == np.float32
    assert ylm.product(np.ones(4, np.float32), np.ones(4)).dtype == np.float64
    assert ylm.product([1, 0, 0, 0], [1, 0, 0, 0]).dtype == np.float64


def test_leading_axes_broadcast(random):
    many, one, few = random.normal(size=(5, 4, 9)), random.normal(size=9), random.normal(size=(5, 1, 4))
    found = ylm.product(many, one, few)
    assert found.shape == (5, 4, 9)
    padded = np.zeros(9)
    padded[:4] = few[2, 0]
    assert np.allclose(found[2, 3], ylm.product(many[2, 3], one, padded), rtol=0, atol=1e-13)
    turns = random.normal(size=(5, 1, 4))
    assert np.allclose(ylm.rotate(many, turns)[4, 1], ylm.rotate(many[4, 1], turns[4, 0]), atol=1e-13)
    kernels = random.normal(size=(4, 3))
    assert np.array_equal(ylm.convolve(many, kernels)[1, 2], ylm.convolve(many[1, 2], kernels[2]))
    assert np.array_equal(ylm.dot(many, one)[3, 2], ylm.dot(many[3, 2], one))
    assert ylm.eval(many, random.normal(size=(6, 7, 3))).shape == (5, 4, 6, 7)


REFUSED = [
    (lambda: ylm.basis(np.zeros((4, 3)), 2), ValueError, r"direction 0 is \(0, 0, 0\); it must be finite and not zero"),
    (lambda: ylm.basis([np.nan, 0, 1], 2), ValueError, "direction 0 is"),
    (lambda: ylm.basis(np.zeros((4, 2)), 2), ValueError, r"directions has shape \(4, 2\); expected \(\.\.\., 3\)"),
    (lambda: ylm.basis([0, 0, 1], 0), ValueError, "bands is 0; it must be at least 1"),
    (lambda: ylm.basis([0, 0, 1], -1), ValueError, "bands is -1"),
    (lambda: ylm.sphere_grid(-1), ValueError, "degree is -1"),
    (lambda: ylm.stratified_samples(4, -1), ValueError, "seed is -1"),
    (lambda: ylm.product(np.zeros(4), bands=-2), ValueError, "bands is -2"),
    (lambda: ylm.basis([0, 0, 1], 257), ValueError, "257 bands asked for"),
    (lambda: ylm.basis([0, 0, 1j], 2), TypeError, "expected real numbers"),
    (lambda: ylm.eval(np.zeros(5), [0, 0, 1]), ValueError, r"coeffs has shape \(5,\); expected \(\.\.\., n²\)"),
    (lambda: ylm.eval(1.0, [0, 0, 1]), ValueError, r"coeffs has shape \(\)"),
    (lambda: ylm.product(), ValueError, "no factors"),
    (lambda: ylm.product(np.zeros((2, 4)), np.zeros((3, 4))), ValueError, r"factor 0 \(2,\), factor 1 \(3,\)"),
    (lambda: ylm.product(np.zeros(4), np.zeros(5)), ValueError, r"shape \(5,\); expected \(\.\.\., n²\)"),
    (lambda: ylm.product(np.zeros(4225), np.zeros(4225)), ValueError, "65 bands asked for; this works for 1 to 64"),
    (lambda: ylm.product(np.zeros(4), method="magic"), ValueError, 'method is "magic"; expected auto'),
    (lambda: ylm.rotate(np.zeros(4), np.diag([1, 1, -1])), ValueError, "reflection"),
    (lambda: ylm.rotate(np.zeros(4), np.zeros(4)), ValueError, "quaternion"),
    (lambda: ylm.rotate(np.zeros(4), np.zeros(5)), ValueError, r"rotation has shape \(5,\)"),
    (lambda: ylm.rotate_z(np.zeros(4), np.inf), ValueError, "angle of rotation is inf"),
    (lambda: ylm.Turn.from_euler("xyw", [0, 0, 0]), ValueError, 'order is "xyw"; expected one of xyz'),
    (lambda: ylm.convolve(np.zeros(9), np.zeros(2)), ValueError, r"zonal has shape \(2,\); expected \(\.\.\., 3\)"),
    (lambda: ylm.window(np.zeros(9), "hann", -1), ValueError, "width"),
    (lambda: ylm.window(np.zeros(9), "blackman", 3), ValueError, 'kind is "blackman"; expected hann'),
    (lambda: ylm.window(np.zeros(9), "hann"), ValueError, "needs a width"),
    (lambda: ylm.window(-np.eye(9)[0], "auto"), ValueError, "mean"),
    (lambda: ylm.zonal.disc(4.0, 3), ValueError, "half angle of a disc is 4"),
    (lambda: ylm.project(lambda d: np.zeros(3), 4), ValueError, r"the function's result has shape \(3,\)"),
    (lambda: ylm.project(lambda d: d[:, 0] / 0, 4), ValueError, "must be finite"),
    (lambda: ylm.project_image(np.zeros((5, 7, 3)), 2), ValueError, "7 wide and 5 high has no usual layout"),
    (lambda: ylm.project_image(np.zeros((5, 7, 3)), 2, "angular"), ValueError, "width / height"),
    (lambda: ylm.project_image(np.zeros((4, 8, 4)), 2), ValueError, r"\(height, width, 3\)"),
    (lambda: ylm.sphere_grid(5000), ValueError, "at most 4096"),
    (lambda: ylm.AxialProduct(np.ones(3), 200), ValueError, "200 bands asked for; this works for 1 to 128"),
    (lambda: ylm.AxialProduct(np.ones((3, 2)), 4), ValueError, r"kernel has shape \(3, 2\); expected \(k,\)"),
    (lambda: ylm.AxialProduct([np.nan], 4), ValueError, "a coefficient of the kernel is NaN"),
    (lambda: ylm.AxialProduct.clamped_cosine(3).in_frame(np.zeros(4)), ValueError, r"of 2 bands; expected \(\.\.\., 9\)"),
    (lambda: ylm.AxialProduct.clamped_cosine(2).in_world(np.zeros(4), np.zeros(3)), ValueError, "finite and not zero"),
    (lambda: ylm.TurnedProduct(np.ones(3), 33), ValueError, "33 bands asked for; this works for 1 to 32"),
    (lambda: ylm.zonal.henyey_greenstein(1.0, 3), ValueError, "asymmetry"),
    (lambda: ylm.zonal.tabulated([0, 0], [1, 2], 3), ValueError, "rise"),
    (lambda: ylm.zonal.tabulated([0, 1], [1, 2, 3], 3), ValueError, r"values has shape \(3,\); expected \(k,\)"),
    (lambda: ylm.zonal.multiply(), ValueError, "no zonal functions"),
    (lambda: ylm.band_integrals(np.zeros(4), np.zeros(4), np.zeros(9)), ValueError, r"h has shape \(9,\); expected \(4,\)"),
    (lambda: ylm.wigner_3j((40, 0, 0), (0, 0, 0)), ValueError, "degree 40 is too large; expected 0 to 31"),
    (lambda: ylm.legendre(3, 3, 0.5), ValueError, "order is 3; expected 0 to 2"),
    (lambda: ylm.legendre(0, 3, 1.5), ValueError, "a cosine is 1.5"),
    (lambda: ylm.index(1, 2), ValueError, "beyond its degree"),
    (lambda: ylm.image_locate([0, 0, 0], 8, 16), ValueError, "must be finite and not zero"),
    (lambda: ylm.product(*np.zeros((7, 16)), method="brute-force"), ValueError, "at most 2.24"),
    (lambda: ylm.polygon(np.eye(3)[:2], 3), ValueError, "corners has 2 values, expected 3"),
    (lambda: ylm.log(np.eye(9)[0] * -1), ValueError, "positive somewhere"),
    (lambda: ylm.exp(np.zeros(441)), ValueError, "1 to 20"),
]


@pytest.mark.parametrize("call, error, message", REFUSED)
@pytest.mark.filterwarnings("ignore:divide by zero", "ignore:invalid value")
def test_what_has_no_answer_is_refused_with_what_was_expected(call, error, message):
    with pytest.raises(error, match=message):
        call()


def test_more_than_memory_holds_is_a_memory_error():
    with pytest.raises(MemoryError):
        ylm.basis(np.ones((2_000_000, 3)), 256)


def test_other_threads_run_meanwhile(random):
    """While a long product runs, this thread goes on: its counter moves before the product is done."""
    factor = random.normal(size=(20_000, 225))
    done = threading.Event()

    def multiply():
        ylm.product(factor, factor)
        done.set()

    worker = threading.Thread(target=multiply)
    steps_meanwhile = 0
    worker.start()
    while not done.is_set():
        steps_meanwhile += 1
    worker.join()
    # With the lock held throughout, the loop would not run once before the product is done, but for what starting takes.
    assert steps_meanwhile > 1000
