"""What channels are called, and which wavelengths they can be."""

from __future__ import annotations

import pytest

from scenes.channels import channel_names, check_wavelengths

NAMES = {1: "Y", 2: "C0 C1", 3: "R G B", 12: "C0 C1 C2 C3 C4 C5 C6 C7 C8 C9 C10 C11"}


@pytest.mark.parametrize("channels", NAMES)
def test_channels_of_a_number(channels: int) -> None:
    assert channel_names(channels) == NAMES[channels].split()


def test_channels_that_are_wavelengths() -> None:
    assert channel_names(3, (404, 412.5, 421)) == ["404 nm", "412.5 nm", "421 nm"]


def test_wavelengths_in_equal_steps() -> None:
    check_wavelengths((400, 410, 420), 3)
    check_wavelengths([380 + i * 400 / 39 for i in range(40)], 40)
    check_wavelengths((360, 830), 2)


@pytest.mark.parametrize("wavelengths", [(400, 410, 430), (500, 490), (500,), (), (400, 400)])
def test_other_steps_are_refused(wavelengths: tuple[float, ...]) -> None:
    with pytest.raises(ValueError, match="expected two or more, ascending in equal steps"):
        check_wavelengths(wavelengths, len(wavelengths))


@pytest.mark.parametrize("wavelengths", [(350, 360), (820, 840), (0.4, 0.5, 0.6)])
def test_what_nobody_sees_is_refused(wavelengths: tuple[float, ...]) -> None:
    with pytest.raises(ValueError, match="expected nanometres from 360 to 830"):
        check_wavelengths(wavelengths, len(wavelengths))


def test_a_channel_too_few() -> None:
    with pytest.raises(ValueError, match="2 channels, expected one per wavelength: 3"):
        check_wavelengths((400, 410, 420), 2)
