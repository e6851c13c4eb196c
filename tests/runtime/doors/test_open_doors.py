from typing import Any

import pytest

from reflexarc_runtime.doors.open_doors import host_and_port, is_loopback, listeners, open_doors

MTLS = {"enable_mtls": True}


def setting_of(**settings: Any) -> Any:
    """As Zenoh resolves a file: what it leaves out is Zenoh's default."""
    resolved = {
        "mode": None,
        "listen/endpoints": {"router": ["tcp/[::]:7447"], "peer": ["tcp/[::]:0"]},
        "connect/endpoints": [],
        "scouting/multicast/enabled": False,
        "scouting/multicast/interface": None,
        "transport/link/tls": {"enable_mtls": None},
        **{name.replace("__", "/"): value for name, value in settings.items()},
    }
    return resolved.__getitem__


@pytest.mark.parametrize(
    "endpoints",
    [
        "tcp/0.0.0.0:7447",
        "tcp/[::]:0",
        "udp/192.168.1.7:7447",
        "ws/10.0.0.1:80",
        "tcp/robot1.local:7447",
        "tcp/[fe80::1%eth0]:7447",
        "tcp/192.168.1.7:7447?rel=1#iface=eth0",
        "vsock/-1:7447",
        "udp/224.0.0.225:7447",
        "some-new-link/10.0.0.1:1",
    ],
)
def test_a_plain_listener_that_others_reach_is_an_open_door(endpoints: str):
    where = ["tcp/127.0.0.1:1", endpoints]
    setting = setting_of(listen__endpoints=where, transport__link__tls=MTLS)
    [words] = open_doors(setting)
    assert endpoints in words


@pytest.mark.parametrize(
    "endpoint",
    [
        "tcp/127.0.0.1:7447",
        "tcp/127.9.9.9:7447",
        "tcp/[::1]:0",
        "tcp/localhost:0",
        "unixsock-stream//tmp/socket",
        "unixpipe/pipe",
    ],
)
def test_what_only_this_machine_reaches_is_none(endpoint: str):
    assert open_doors(setting_of(listen__endpoints=[endpoint])) == []


def test_a_peer_and_a_router_that_say_nothing_of_it_listen_everywhere_and_a_client_nowhere():
    assert listeners(setting_of()) == ["tcp/[::]:0"]
    assert listeners(setting_of(mode="router")) == ["tcp/[::]:7447"]
    assert listeners(setting_of(mode="client")) == []
    assert len(open_doors(setting_of())) == 1
    assert open_doors(setting_of(mode="client")) == []


@pytest.mark.parametrize("mtls", [None, False])
def test_tls_that_asks_nobody_for_a_certificate_lets_in_everybody(mtls: bool | None):
    tls = {"enable_mtls": mtls}
    where = ["tls/10.0.0.1:7447"]
    assert (
        "certificate"
        in open_doors(setting_of(listen__endpoints=where, transport__link__tls=tls))[0]
    )
    assert open_doors(setting_of(listen__endpoints=where, transport__link__tls=MTLS)) == []


def test_what_a_locator_says_of_certificates_comes_before_the_setting():
    undone = ["tls/10.0.0.1:7447#iface=eth0;enable_mtls=false"]
    assert open_doors(setting_of(listen__endpoints=undone, transport__link__tls=MTLS)) != []
    done = ["tls/10.0.0.1:7447#enable_mtls=true"]
    assert open_doors(setting_of(listen__endpoints=done)) == []


def test_one_list_for_each_mode_and_groups_are_read():
    both = {"peer": [{"strategy": "allOf", "locators": ["tcp/1.2.3.4:5"]}, ["tcp/6.7.8.9:1"]]}
    assert listeners(setting_of(listen__endpoints=both)) == ["tcp/1.2.3.4:5", "tcp/6.7.8.9:1"]
    assert listeners(setting_of(mode="client", listen__endpoints=both)) == []


@pytest.mark.parametrize("enabled", [None, True])
def test_multicast_is_an_open_door_unless_it_is_switched_off(enabled: bool | None):
    quiet = {"listen__endpoints": [], "scouting__multicast__enabled": enabled}
    assert "multicast" in open_doors(setting_of(**quiet))[0]
    assert open_doors(setting_of(**quiet, scouting__multicast__interface="lo")) == []


def test_a_client_that_is_told_its_router_looks_for_no_other():
    told = {"mode": "client", "scouting__multicast__enabled": True}
    assert open_doors(setting_of(**told, connect__endpoints=["tcp/10.0.0.1:7447"])) == []
    assert open_doors(setting_of(**told)) != []


def test_addresses_are_read_out_of_locators():
    assert host_and_port("tls/[::1]:7447?rel=1#iface=lo") == ("::1", 7447)
    assert host_and_port("tcp/robot1.local:80") == ("robot1.local", 80)
    assert host_and_port("tcp/nowhere") == ("", 0)


def test_a_name_that_only_begins_like_the_loopback_is_none():
    assert not any(map(is_loopback, ("localhost.evil.example", "127.0.0.1.evil.example", "", "lo")))
