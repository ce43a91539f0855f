"""The verification report: findings of several studies on one machine, put together."""
