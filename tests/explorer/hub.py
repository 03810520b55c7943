"""What a JupyterHub does for a page: it passes a port on, below a path of its own."""

import asyncio
import threading

from tornado.httpclient import AsyncHTTPClient, HTTPRequest
from tornado.httpserver import HTTPServer
from tornado.netutil import bind_sockets
from tornado.web import Application, RequestHandler
from tornado.websocket import WebSocketHandler, websocket_connect

__all__ = ["Hub"]


class _Page(RequestHandler):
    async def get(self, port: str, path: str) -> None:
        url = f"http://127.0.0.1:{port}/{path}?{self.request.query}"
        found = await AsyncHTTPClient().fetch(url, raise_error=False)
        self.set_status(found.code)
        self.set_header("Content-Type", found.headers.get("Content-Type", "text/plain"))
        self.finish(found.body)


class _Socket(WebSocketHandler):
    def check_origin(self, origin: str) -> bool:
        return True

    def select_subprotocol(self, offered: list[str]) -> str:
        return offered[0]

    async def open(self, port: str) -> None:
        asked = {name: self.request.headers[name] for name in ("Origin", "Sec-WebSocket-Protocol")}
        url = f"ws://127.0.0.1:{port}/ws"
        self.other = await websocket_connect(HTTPRequest(url, headers=asked))
        self.task = asyncio.ensure_future(self._back())

    async def _back(self) -> None:
        while (message := await self.other.read_message()) is not None:
            await self.write_message(message, binary=isinstance(message, bytes))
        self.close()

    async def on_message(self, message: str | bytes) -> None:
        await self.other.write_message(message, binary=isinstance(message, bytes))

    def on_close(self) -> None:
        self.other.close()


class Hub:
    """Passes on ``/user/me/proxy/PORT/...`` until it is closed, as jupyter-server-proxy does."""

    prefix = "/user/me/"

    def __init__(self) -> None:
        self.loop, ready = asyncio.new_event_loop(), threading.Event()
        self.thread = threading.Thread(target=self._serve, args=[ready], daemon=True)
        self.thread.start()
        ready.wait()

    def _serve(self, ready: threading.Event) -> None:
        asyncio.set_event_loop(self.loop)
        base = f"{self.prefix}proxy/([0-9]+)/"
        server = HTTPServer(Application([(f"{base}ws", _Socket), (f"{base}(.*)", _Page)]))
        (socket,) = bind_sockets(0, "127.0.0.1")
        server.add_sockets([socket])
        self.url = f"http://127.0.0.1:{socket.getsockname()[1]}"
        ready.set()
        self.loop.run_forever()
        server.stop()

    def close(self) -> None:
        """End it."""
        self.loop.call_soon_threadsafe(self.loop.stop)
        self.thread.join(10)
