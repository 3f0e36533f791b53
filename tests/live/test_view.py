"""A request asks for a view: malformed and too large ones are refused with a sentence."""

import pytest

from rtcli.live.view import CameraPose, RequestError, ViewRequest

POSE = {"position": "0,1,8", "look_at": "0,1,0", "up": "0,1,0"}


def test_empty_query_is_the_view_of_the_file():
    assert ViewRequest.of_query({"version": "3"}) == ViewRequest()


def test_query_gives_exposure_pose_and_size():
    query = {**POSE, "exposure": "-1.5", "size": "320x240"}
    assert ViewRequest.of_query(query) == ViewRequest(
        -1.5, CameraPose((0, 1, 8), (0, 1, 0), (0, 1, 0)), (320, 240)
    )


@pytest.mark.parametrize(
    ("query", "reason"),
    [
        ({"exposure": "bright"}, "exposure: expected a number"),
        ({"exposure": "nan"}, "exposure: expected a number"),
        ({"exposure": "1e9"}, "exposure: expected a number"),
        ({"size": "640"}, "size: expected WxH"),
        ({"size": "0x5"}, "size: expected WxH"),
        ({"size": "65536x1"}, "size: expected WxH"),
        ({"size": "٣x٣"}, "size: expected WxH"),
        ({"position": "1,2,3"}, "must be given together"),
        ({**POSE, "up": "0,1"}, "up: expected three numbers"),
        ({**POSE, "position": "inf,0,0"}, "position: expected a number"),
        ({**POSE, "look_at": "0,1,8"}, "look_at must differ"),
        ({**POSE, "up": "0,0,1"}, "up must not be"),
        ({**POSE, "up": "0,0,0"}, "up must not be"),
    ],
)
def test_malformed_queries_are_refused(query, reason):
    with pytest.raises(RequestError, match=reason):
        ViewRequest.of_query(query)
