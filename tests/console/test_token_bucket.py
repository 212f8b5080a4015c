"""A rate that is limited, with bursts."""

from drake_mobman.console.token_bucket import TokenBucket


def test_bucket_allows_a_burst_and_then_its_rate(clock):
    bucket = TokenBucket(2.0, 3.0, clock)
    assert [bucket.take() for _ in range(4)] == [True] * 3 + [False]
    clock.now += 0.5
    assert [bucket.take() for _ in range(2)] == [True, False]


def test_bucket_holds_no_more_than_its_capacity_however_long_it_fills(clock):
    bucket = TokenBucket(2.0, 3.0, clock)
    clock.now += 1000.0
    assert not bucket.take(3.5)
    assert bucket.take(3.0)
    assert not bucket.take(0.5)
