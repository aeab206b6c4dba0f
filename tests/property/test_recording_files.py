"""Whatever bytes a file holds, it is read or refused in words; never a traceback."""

import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from cardan.core.errors import InvalidFileError
from cardan.readers.dispatch import open_recording

pytest.importorskip("pyarrow")

field = st.sampled_from(["1", "2.5", "-3,5", "1e3", "", "nan", "x", '"', "S1", "time", "°C", "inf"])
row = st.lists(field, max_size=4)
table = st.builds(
    lambda rows, delimiter, end: end.join(delimiter.join(r) for r in rows),
    st.lists(row, max_size=12),
    st.sampled_from([",", ";", "\t", " ", "|"]),
    st.sampled_from(["\n", "\r\n"]),
)
modest = settings(max_examples=120, suppress_health_check=[HealthCheck.function_scoped_fixture])


def read_or_refuse(path):
    try:
        recording = open_recording(path, rate=100.0)
        x = recording.read_all()
    except InvalidFileError as error:
        assert str(path) in str(error)  # noqa: PT017  either way is right
    else:
        assert x.shape[0] in (0, len(recording.channels))


@pytest.mark.slow
@modest
@given(text=table, encoding=st.sampled_from(["utf-8", "latin-1", "utf-16"]))
def test_any_table_is_read_or_rejected(tmp_path, text, encoding):
    (tmp_path / "a.csv").write_bytes(text.encode(encoding))
    read_or_refuse(tmp_path / "a.csv")


@modest
@given(
    data=st.binary(max_size=300), ending=st.sampled_from(["csv", "wav", "parquet", "h5", "tdms"])
)
def test_any_bytes_are_read_or_rejected(tmp_path, data, ending):
    pytest.importorskip("h5py")
    pytest.importorskip("nptdms")
    (tmp_path / f"a.{ending}").write_bytes(data)
    read_or_refuse(tmp_path / f"a.{ending}")


@modest
@given(data=st.binary(max_size=60))
def test_any_wav_body_is_read_or_rejected(tmp_path, data):
    (tmp_path / "a.wav").write_bytes(b"RIFF\xff\xff\xff\xffWAVEfmt " + data)
    read_or_refuse(tmp_path / "a.wav")
